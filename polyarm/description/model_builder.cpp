#include "polyarm/description/model_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "polyarm/base/text.hpp"
#include "polyarm/description/shape_bounds.hpp"
#include "polyarm/description/suggestions.hpp"

namespace polyarm::description {

namespace {

using Index = std::map<std::string, int, std::less<>>;

Index index_links(const RobotModel& model, const Location& file, Problems& problems) {
  Index out;
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (!out.emplace(model.links[i].name, static_cast<int>(i)).second)
      problems.error("duplicate-name", file, "two links are called '" + model.links[i].name + "'",
                     "rename one of them");
  return out;
}

std::vector<std::string> names_of(const Index& index) {
  std::vector<std::string> out;
  for (const auto& [name, at] : index) out.push_back(name);
  return out;
}

/// Several joints between the same two links, as simplified models of vehicles have: in ROS the last one by
/// name moves the link, and all of them have values. Each of the others gets an empty link of its own.
void split_parallel_joints(RobotModel& model, std::vector<NamedJoint>& joints, Index& links,
                           Problems& warnings) {
  std::map<std::pair<std::string, std::string>, std::vector<NamedJoint*>> between;
  for (NamedJoint& j : joints)
    if (j.parent != j.child) between[{j.parent, j.child}].push_back(&j);
  for (auto& [ends, all] : between) {
    if (all.size() < 2 || !links.contains(ends.second)) continue;
    const auto by_name = [](const NamedJoint* a, const NamedJoint* b) {
      return a->joint.name < b->joint.name;
    };
    const NamedJoint* last = *std::max_element(all.begin(), all.end(), by_name);
    warnings.warning(
        "two-parents", all[1]->where,
        std::to_string(all.size()) + " joints lead from '" + ends.first + "' to '" + ends.second + "'",
        "the link moves with '" + last->joint.name + "' alone, as in ROS; the others move without a link");
    for (NamedJoint* each : all) {
      const std::string own = ends.second + "_of_" + each->joint.name;
      if (each == last || links.contains(own)) continue;
      links.emplace(own, static_cast<int>(model.links.size()));
      model.links.emplace_back().name = own;
      each->child = own;
    }
  }
}

/// Fills the link indices of the joints; false if a name is unknown.
bool resolve(const RobotModel& model, std::vector<NamedJoint>& joints, const Index& links,
             Problems& problems) {
  bool good = true;
  Suggestions suggest;
  std::map<std::string, int> seen;
  std::vector<int> parents(model.links.size(), 0);
  for (NamedJoint& j : joints) {
    if (seen[j.joint.name]++ > 0) {
      problems.error("duplicate-name", j.where, "two joints are called '" + j.joint.name + "'",
                     "rename one of them");
      good = false;
    }
    for (const auto& [link, target] :
         {std::pair{&j.parent, &j.joint.parent_link}, {&j.child, &j.joint.child_link}}) {
      const auto found = links.find(*link);
      if (found == links.end()) {
        problems.error("unknown-link", j.where,
                       "the joint '" + j.joint.name + "' names the link '" + *link +
                           "', which does not exist" + suggest(*link, [&] { return names_of(links); }));
        good = false;
      } else {
        *target = found->second;
      }
    }
    if (j.joint.child_link >= 0 && parents[static_cast<std::size_t>(j.joint.child_link)]++ > 0) {
      problems.error("two-parents", j.where, "the link '" + j.child + "' is the child of more than one joint",
                     "a robot is a tree; remove one of the joints");
      good = false;
    }
  }
  return good;
}

/// Parents before children, otherwise in the order given.
bool sort_joints(RobotModel& model, std::vector<NamedJoint>& joints, const Location& file,
                 Problems& problems) {
  std::vector<std::string> roots;
  std::vector<char> placed(model.links.size(), 1);
  for (const NamedJoint& j : joints) placed[static_cast<std::size_t>(j.joint.child_link)] = 0;
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (placed[i]) {
      roots.push_back(model.links[i].name);
      model.root = static_cast<int>(i);
    }
  if (roots.size() > 1) {
    problems.error("several-roots", file,
                   "the links " + join(roots, ", ") + " have no parent; a robot has one root",
                   "join them with fixed joints, or remove what does not belong to the robot");
    return false;
  }
  std::vector<NamedJoint> sorted;
  std::vector<char> used(joints.size(), 0);
  for (bool progress = true; progress && sorted.size() < joints.size();) {
    progress = false;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (used[i] || !placed[static_cast<std::size_t>(joints[i].joint.parent_link)]) continue;
      used[i] = 1;
      progress = true;
      placed[static_cast<std::size_t>(joints[i].joint.child_link)] = 1;
      sorted.push_back(joints[i]);
    }
  }
  if (sorted.size() < joints.size() || roots.empty()) {
    problems.error("circle", file, "some links are each other's parents: the joints form a circle", {});
    return false;
  }
  joints = std::move(sorted);
  return true;
}

bool has_one_value(JointType type) {
  return type == JointType::revolute || type == JointType::continuous || type == JointType::prismatic;
}

std::vector<std::string> names_to_follow(const RobotModel& model) {
  std::vector<std::string> out;
  for (const Joint& joint : model.joints)
    if (has_one_value(joint.type)) out.push_back(joint.name);
  return out;
}

/// Finds the leading joints. A joint that cannot follow becomes independent, as in robot_state_publisher and
/// KDL.
void find_mimicked(RobotModel& model, const std::vector<NamedJoint>& joints, Problems& warnings) {
  const auto alone = [&](std::size_t i, const std::string& why) {
    warnings.warning("bad-mimic", joints[i].where,
                     "the joint '" + joints[i].joint.name + "' mimics '" + joints[i].mimics + "', " + why,
                     "its <mimic> is ignored: the joint moves by itself");
    model.joints[i].mimic.reset();
  };
  Suggestions suggest;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!model.joints[i].mimic) continue;
    const int source = model.find_joint(joints[i].mimics);
    if (source < 0) {
      alone(i, "which does not exist" + suggest(joints[i].mimics, [&] { return names_to_follow(model); }));
      continue;
    }
    const JointType type = model.joints[static_cast<std::size_t>(source)].type;
    if (has_one_value(type))
      model.joints[i].mimic->joint = source;
    else
      alone(i, std::string("whose type ") + name(type) + " has no one value to follow");
  }
}

/// Followers of followers are connected to the first leader.
void shorten_mimic_rows(RobotModel& model, const std::vector<NamedJoint>& joints, Problems& warnings) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    auto& mimic = model.joints[i].mimic;
    for (std::size_t steps = 0; mimic && model.joints[static_cast<std::size_t>(mimic->joint)].mimic;
         ++steps) {
      if (steps > joints.size()) {
        warnings.warning("bad-mimic", joints[i].where,
                         "the joint '" + model.joints[i].name + "' mimics itself in the end",
                         "its <mimic> is ignored: the joint moves by itself");
        mimic.reset();
        break;
      }
      const Mimic next = *model.joints[static_cast<std::size_t>(mimic->joint)].mimic;
      *mimic = {next.joint, mimic->multiplier * next.multiplier,
                mimic->multiplier * next.offset + mimic->offset};
    }
  }
}

double volume(const Shape& s) {
  constexpr double pi = std::numbers::pi;
  switch (s.kind) {
    case ShapeKind::box:
      return s.size.x * s.size.y * s.size.z;
    case ShapeKind::cylinder:
      return pi * s.radius * s.radius * s.length;
    case ShapeKind::sphere:
      return 4.0 / 3 * pi * s.radius * s.radius * s.radius;
    case ShapeKind::capsule:
      return pi * s.radius * s.radius * (s.length + 4.0 / 3 * s.radius);
    case ShapeKind::mesh:
      return 0;
  }
  return 0;
}

/// Diagonal of the inertia of unit mass about the shape's centre in its own axes.
Vec3 unit_inertia(const Shape& s) {
  switch (s.kind) {
    case ShapeKind::box:
      return {(s.size.y * s.size.y + s.size.z * s.size.z) / 12,
              (s.size.x * s.size.x + s.size.z * s.size.z) / 12,
              (s.size.x * s.size.x + s.size.y * s.size.y) / 12};
    case ShapeKind::sphere:
      return {0.4 * s.radius * s.radius, 0.4 * s.radius * s.radius, 0.4 * s.radius * s.radius};
    default: {  // a capsule counts as a cylinder of its whole length
      const double l = s.length + (s.kind == ShapeKind::capsule ? 4.0 / 3 * s.radius : 0);
      const double across = (3 * s.radius * s.radius + l * l) / 12;
      return {across, across, s.radius * s.radius / 2};
    }
  }
}

/// R diag(d) R^T as ixx ixy ixz iyy iyz izz.
std::array<double, 6> rotated(const Quaternion& q, const Vec3& d) {
  const Vec3 x = q * Vec3{1, 0, 0}, y = q * Vec3{0, 1, 0}, z = q * Vec3{0, 0, 1};
  const auto entry = [&](double a1, double b1, double a2, double b2, double a3, double b3) {
    return d.x * a1 * b1 + d.y * a2 * b2 + d.z * a3 * b3;
  };
  return {entry(x.x, x.x, y.x, y.x, z.x, z.x), entry(x.x, x.y, y.x, y.y, z.x, z.y),
          entry(x.x, x.z, y.x, y.z, z.x, z.z), entry(x.y, x.y, y.y, y.y, z.y, z.y),
          entry(x.y, x.z, y.y, y.z, z.y, z.z), entry(x.z, x.z, y.z, y.z, z.z, z.z)};
}

}  // namespace

namespace {
/// The number of decimals of the shortest text that gives the same value.
int decimals_of(double value) {
  const std::string text = format_number(value);
  const auto point = text.find('.');
  if (point == std::string::npos || text.find('e') != std::string::npos) return 0;
  return static_cast<int>(text.size() - point - 1);
}

bool settle_angle(double& angle) {
  constexpr double kStep = 0.25 * std::numbers::pi, kWithin = 1e-5;
  const double exact = kStep * std::round(angle / kStep), change = std::abs(angle - exact);
  if (exact == 0 || change == 0 || change > kWithin) return false;
  const int decimals = decimals_of(angle);
  if (decimals < 4 || decimals > 9 || change > std::pow(10, -decimals)) return false;
  angle = exact;
  return true;
}

}  // namespace

bool settle_angles(Vec3& rpy) {
  const bool x = settle_angle(rpy.x), y = settle_angle(rpy.y), z = settle_angle(rpy.z);
  return x || y || z;
}

bool tie_together(RobotModel& model, std::vector<NamedJoint> joints, const Location& file, Problems& problems,
                  Problems& warnings) {
  if (model.links.empty()) {
    problems.error("no-links", file, "the description has no links", "is this a robot description?");
    return false;
  }
  Index links = index_links(model, file, problems);
  if (links.size() != model.links.size()) return false;
  split_parallel_joints(model, joints, links, warnings);
  if (!resolve(model, joints, links, problems) || !sort_joints(model, joints, file, problems)) return false;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    model.links[static_cast<std::size_t>(joints[i].joint.child_link)].parent_joint = static_cast<int>(i);
    model.joints.push_back(joints[i].joint);
  }
  find_mimicked(model, joints, warnings);
  shorten_mimic_rows(model, joints, warnings);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (has_one_value(model.joints[i].type) && !model.joints[i].mimic)
      model.actuated.push_back(static_cast<int>(i));
  }
  return true;
}

namespace {
std::vector<Shape> boxes_for_meshes(const std::vector<Shape>& shapes) {
  std::vector<Shape> out;
  for (const Shape& shape : shapes) {
    if (shape.kind != ShapeKind::mesh) out.push_back(shape);
    for (const auto& piece : shape.pieces) {
      Shape one;
      one.kind = ShapeKind::mesh;
      one.pieces = {piece};
      const Bounds around = bounds_of(one, {});
      Shape box;
      box.size = around.upper - around.lower;
      box.pose = shape.pose * Pose{0.5 * (around.lower + around.upper), {}};
      out.push_back(box);
    }
  }
  return out;
}
}  // namespace

Inertial inertial_of(const std::vector<Shape>& all, double density) {
  Inertial out;
  const std::vector<Shape> shapes = boxes_for_meshes(all);
  for (const Shape& s : shapes) {
    const double m = density * volume(s);
    out.mass += m;
    out.center = out.center + m * s.pose.position;
  }
  if (out.mass <= 0) return out;
  out.center = (1 / out.mass) * out.center;
  for (const Shape& s : shapes) {
    const double m = density * volume(s);
    const std::array<double, 6> own = rotated(s.pose.rotation, m * unit_inertia(s));
    const Vec3 r = s.pose.position - out.center;
    const double rr = dot(r, r);
    const std::array<double, 6> moved = {m * (rr - r.x * r.x), -m * r.x * r.y, -m * r.x * r.z,
                                         m * (rr - r.y * r.y), -m * r.y * r.z, m * (rr - r.z * r.z)};
    for (std::size_t k = 0; k < 6; ++k) out.inertia[k] += own[k] + moved[k];
  }
  return out;
}

bool plausible(const Inertial& inertial) {
  const auto& [xx, xy, xz, yy, yz, zz] = inertial.inertia;
  if (!(inertial.mass > 0) || !(xx > 0) || !(yy > 0) || !(zz > 0)) return false;
  // Positive definite by its minors; the triangle inequality of the diagonal is necessary in all axes.
  const double det2 = xx * yy - xy * xy;
  const double det3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const double slack = 1e-9 + 1e-3 * (xx + yy + zz);
  return det2 > 0 && det3 > 0 && xx + yy >= zz - slack && yy + zz >= xx - slack && xx + zz >= yy - slack;
}

void complete_inertials(RobotModel& model, Problems& warnings) {
  // Typical density of arms relative to the volume of the capsules around their links, which are loose.
  constexpr double kDensity = 700;
  std::vector<std::string> estimated, repaired;
  for (Link& link : model.links) {
    if (link.parent_joint < 0 && !link.inertial) continue;  // the base does not move
    const bool has_mass = link.inertial && link.inertial->mass > 0;
    if (!has_mass && link.collisions.empty()) continue;  // a frame
    if (has_mass && plausible(*link.inertial)) continue;
    Inertial guess = inertial_of(link.collisions, kDensity);
    if (has_mass && guess.mass > 0) {
      const double scale = link.inertial->mass / guess.mass;
      for (double& value : guess.inertia) value *= scale;
      guess.mass = link.inertial->mass;
      guess.center = link.inertial->center;
    } else if (has_mass) {
      guess = *link.inertial;
      const double small = 1e-3 * guess.mass;
      guess.inertia = {small, 0, 0, small, 0, small};
    }
    if (guess.mass <= 0) continue;
    (has_mass ? repaired : estimated).push_back(link.name);
    guess.estimated = true;
    link.inertial = guess;
  }
  if (!estimated.empty())
    model.provenance.notes.push_back("mass and inertia estimated from the shapes of " +
                                     join(estimated, ", "));
  if (!repaired.empty()) {
    model.provenance.notes.push_back("inertia estimated (the stated one belongs to no body) of " +
                                     join(repaired, ", "));
    warnings.warning(
        "inertia", {},
        "the inertia of " + join(repaired, ", ") + " belongs to no body; estimated from shape and mass");
  }
}

}  // namespace polyarm::description
