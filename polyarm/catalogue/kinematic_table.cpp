#include "polyarm/catalogue/kinematic_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

Pose along_x(double a, double alpha) {
  return {{a, 0, 0}, from_axis_angle({1, 0, 0}, alpha)};
}

Pose along_z(double d, double theta) {
  return {{0, 0, d}, from_axis_angle({0, 0, 1}, theta)};
}

JointType row_type(const Yaml& row) {
  const std::string text = row["type"].text("revolute");
  for (const JointType type : {JointType::revolute, JointType::continuous, JointType::prismatic})
    if (text == name(type)) return type;
  throw Error(Problem{"bad-value", row["type"].where(), "'" + text + "' is not a type of a row",
                      "revolute, continuous or prismatic"});
}

struct DhRow {
  double a, alpha, d, theta;
};

/// Reads a row of a DH table. The parameter to which the joint's value is added is optional.
DhRow read_dh(const Yaml& row, JointType type) {
  const bool slides = type == JointType::prismatic;
  DhRow out{
      row.required("a").number(Dimension::length), row.required("alpha").number(Dimension::angle),
      slides ? row["d"].number(Dimension::length, 0) : row.required("d").number(Dimension::length),
      slides ? row.required("theta").number(Dimension::angle) : row["theta"].number(Dimension::angle, 0)};
  if (!(std::max(std::abs(out.a), std::abs(out.d)) < 1000))
    throw Error(Problem{"bad-value", row.where(), "a robot is smaller than a kilometre", "write metres"});
  return out;
}

struct Screw {
  Vec3 axis, point;
};

Vec3 direction(const Vec3& given, const Location& where) {
  const double length = norm(given);
  if (!(length > 1e-9) || !std::isfinite(length))
    throw Error(Problem{"zero-axis", where, "the axis has no direction", "write [0, 0, 1]"});
  return (1 / length) * given;
}

/// [wx, wy, wz, vx, vy, vz]: the axis and the velocity of the base's origin about it (v = -w x point).
Screw from_screw(const Yaml& yaml, bool slides) {
  const std::vector<double> s = yaml.numbers();
  if (s.size() != 6)
    throw Error(Problem{"bad-value", yaml.where(),
                        "a screw axis has six numbers, here are " + std::to_string(s.size()),
                        "write [wx, wy, wz, vx, vy, vz]"});
  const Vec3 w{s[0], s[1], s[2]}, v{s[3], s[4], s[5]};
  if (slides) {
    if (norm(w) > 1e-9)
      throw Error(Problem{"bad-value", yaml.where(), "a prismatic joint does not turn: w must be zero", {}});
    return {direction(v, yaml.where()), {}};
  }
  const Vec3 unit = direction(w, yaml.where());
  if (std::abs(norm(w) - 1) > 1e-6)
    throw Error(Problem{"bad-value", yaml.where(), "w is not a unit vector", "divide w and v by its length"});
  if (std::abs(dot(unit, v)) > 1e-6)
    throw Error(Problem{"screw-pitch", yaml.where(),
                        "w and v are not at right angles: such a joint would move along its axis as it turns",
                        "v is -w x (a point of the axis)"});
  return {unit, cross(unit, v)};
}

Screw read_screw(const Yaml& row, JointType type) {
  const bool slides = type == JointType::prismatic;
  if (row.has("screw")) return from_screw(row["screw"], slides);
  const Yaml axis = row.required("axis");
  return {direction(axis.vec3(Dimension::none), axis.where()),
          slides && !row.has("point") ? Vec3{} : row.required("point").vec3()};
}

/// Adds the row number to an error.
Error in_row(const Error& e, std::size_t number, const Yaml& row) {
  std::vector<Problem> out = e.problems();
  for (Problem& p : out) {
    p.what = "row " + std::to_string(number) + " (" + row["name"].text("no name") + "): " + p.what;
    if (p.where.line == 0) p.where = row.where();
  }
  return Error(std::move(out));
}

template <class Step>
void each_row(const Yaml& rows, Problems& problems, Step step) {
  std::size_t number = 0;
  for (const Yaml& row : rows.items()) {
    ++number;
    try {
      step(row);
    } catch (const Error& e) {
      problems.add(in_row(e, number, row));
    }
  }
}

KinematicTable read_dh_table(bool modified, const Yaml& rows, const Pose& flange, Problems& problems) {
  KinematicTable out;
  Pose pending;  // the part of the previous row after its joint
  each_row(rows, problems, [&](const Yaml& row) {
    TableJoint joint;
    joint.type = row_type(row);
    const DhRow p = read_dh(row, joint.type);
    if (modified) {
      joint.origin = along_x(p.a, p.alpha) * along_z(p.d, p.theta);
    } else {
      joint.origin = pending * along_z(0, p.theta);
      pending = Pose{{0, 0, p.d}, {}} * along_x(p.a, p.alpha);
    }
    out.joints.push_back(joint);
  });
  out.flange = pending * flange;
  return out;
}

KinematicTable read_screws(const Yaml& rows, const Pose& flange, Problems& problems) {
  KinematicTable out;
  Vec3 before;
  each_row(rows, problems, [&](const Yaml& row) {
    TableJoint joint;
    joint.type = row_type(row);
    const Screw screw = read_screw(row, joint.type);
    joint.axis = screw.axis;
    const Vec3 at = joint.type == JointType::prismatic && !row.has("point") ? before : screw.point;
    joint.origin.position = at - before;
    before = at;
    out.joints.push_back(joint);
  });
  out.flange = flange;
  out.flange.position = flange.position - before;
  return out;
}

Shape capsule_to(const Vec3& end, double radius) {
  Shape out;
  out.kind = ShapeKind::capsule;
  out.radius = radius;
  out.length = norm(end);
  out.pose.position = 0.5 * end;
  if (out.length > 1e-9) out.pose.rotation = rotation_between({0, 0, 1}, (1 / out.length) * end);
  return out;
}

/// The vector from a link's frame to the end of the link: the next moving joint, else the farthest fixed one.
Vec3 way_on(const RobotModel& model, int link) {
  Vec3 furthest;
  for (const Joint& joint : model.joints) {
    if (joint.parent_link != link) continue;
    if (joint.moves()) return joint.origin.position;
    const Vec3 behind = joint.origin * way_on(model, joint.child_link);
    if (norm(behind) > norm(furthest)) furthest = behind;
  }
  return furthest;
}

/// The number of moving joints before each link.
std::vector<int> depths(const RobotModel& model) {
  std::vector<int> out(model.links.size(), 0);
  for (const Joint& joint : model.joints)
    out[static_cast<std::size_t>(joint.child_link)] =
        out[static_cast<std::size_t>(joint.parent_link)] + joint.moves();
  return out;
}

}  // namespace

const std::vector<std::string>& table_keys(TableKind kind) {
  static const std::vector<std::string> dh{"a", "alpha", "d", "theta"}, poe{"axis", "point", "screw"};
  return kind == TableKind::poe ? poe : dh;
}

TableKind table_kind(const Yaml& yaml) {
  const std::string text = yaml.text();
  const std::vector<std::string> names{"dh", "modified_dh", "poe"};
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end())
    throw Error(Problem{
        "bad-value", yaml.where(), "'" + text + "' is not a kind of table" + did_you_mean(text, names),
        "dh, modified_dh or poe; without `kinematics` joints have parent, child, xyz and rpy"});
  return static_cast<TableKind>(found - names.begin());
}

KinematicTable read_table(TableKind kind, const Yaml& rows, const Yaml& flange, Problems& problems) {
  const Pose end = flange.defined() ? flange.pose() : Pose{};
  if (kind == TableKind::poe) return read_screws(rows, end, problems);
  return read_dh_table(kind == TableKind::modified_dh, rows, end, problems);
}

void derive_shapes(RobotModel& model) {
  const std::vector<int> depth = depths(model);
  double span = 0;
  for (const Joint& joint : model.joints) span += norm(joint.origin.position);
  if (!(span > 0)) return;
  std::vector<bool> carries(model.links.size(), false);  // the root, and every link that a joint moves
  carries[static_cast<std::size_t>(model.root)] = true;
  for (const Joint& joint : model.joints) carries[static_cast<std::size_t>(joint.child_link)] = joint.moves();
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (!carries[i]) continue;
    const double radius = span * std::max(0.06 - 0.006 * depth[i], 0.02);
    model.links[i].collisions = {capsule_to(way_on(model, static_cast<int>(i)), radius)};
    model.links[i].visuals = model.links[i].collisions;
    for (std::size_t k = 0; k < i; ++k)
      if (carries[k] && std::abs(depth[i] - depth[k]) <= 2)
        model.allowed_collisions.push_back({static_cast<int>(k), static_cast<int>(i)});
  }
  model.provenance.notes.emplace_back("shapes are capsules derived from the chain");
  model.provenance.notes.emplace_back("links up to two joints apart are not compared with each other");
}

}  // namespace polyarm::description
