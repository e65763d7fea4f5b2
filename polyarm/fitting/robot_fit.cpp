#include "polyarm/fitting/robot_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <random>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/fitting/fit_look.hpp"
#include "polyarm/hulls/triangle_tree.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/shapes/measured_look.hpp"
#include "polyarm/shapes/robot_shapes.hpp"

namespace polyarm::fitting {

using description::RobotModel;
using description::Shape;
using description::ShapeKind;
using hulls::Triangle;

namespace {

constexpr int kSamples = 4'000;
constexpr double kSameJoints =
    5;  // a robot with the same joints may have meshes that are so much further off

/// Adds the triangles of a mesh, moved by `pose`.
void place_into(std::vector<Triangle>& out, const meshes::Mesh& mesh, const Pose& pose) {
  for (const Triangle& t : hulls::surface_of(mesh)) out.push_back({pose * t[0], pose * t[1], pose * t[2]});
}

/// What most names of `theirs` have before a name of `ours`: the prefix of a robot in a description for
/// several.
std::string prefix_of(const std::vector<std::string>& theirs, const std::vector<std::string>& ours) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& longer : theirs)
    for (const std::string& name : ours)
      if (longer.ends_with(name)) ++counts[longer.substr(0, longer.size() - name.size())];
  const auto most = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
    return a.second < b.second;  // of equal ones the first, which is the shortest
  });
  return most == counts.end() ? "" : most->first;
}

/// The names without the prefix, empty where they do not have it.
std::vector<std::string> without(const std::string& prefix, std::vector<std::string> names) {
  for (std::string& name : names) name = name.starts_with(prefix) ? name.substr(prefix.size()) : "";
  return names;
}

std::vector<std::string> link_names(const RobotModel& model) {
  std::vector<std::string> out;
  for (const description::Link& link : model.links) out.push_back(link.name);
  return out;
}

/// The poses of all links in the world. Joints take the values of `by_name`, others zero. `names`: of the
/// moving joints.
std::vector<Pose> posed(const RobotModel& model, const std::vector<std::string>& names,
                        const std::map<std::string, double>& by_name) {
  std::vector<double> q;
  for (const std::string& name : names) q.push_back(by_name.contains(name) ? by_name.at(name) : 0);
  std::vector<Pose> out(model.links.size());
  kinematics::Chain(model, model.tool_link()).link_poses(q, out);
  return out;
}

/// Points of the surface that are visible from outside, by area.
std::vector<Vec3> samples(const std::vector<Triangle>& triangles, const hulls::TriangleTree& tree) {
  std::vector<double> sums;
  double sum = 0;
  for (const Triangle& t : triangles) sums.push_back(sum += norm(cross(t[1] - t[0], t[2] - t[0])));
  std::mt19937_64 draw(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3> out;
  for (int i = 0; i < kSamples; ++i) {
    const auto at = std::upper_bound(sums.begin(), sums.end(), share(draw) * sum);
    const Triangle& t = triangles[static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(at - sums.begin(), std::ssize(sums) - 1))];
    double u = share(draw), v = share(draw);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    if (is_visible(tree, p, cross(t[1] - t[0], t[2] - t[0]))) out.push_back(p);
  }
  return out;
}

/// The distances of the visible surface of `from` to `to`, in ascending order.
std::vector<double> distances(const std::vector<Triangle>& from, const std::vector<Triangle>& to) {
  const hulls::TriangleTree tree(to);
  std::vector<double> out;
  for (const Vec3& p : samples(from, hulls::TriangleTree(from))) out.push_back(tree.distance(p));
  std::sort(out.begin(), out.end());
  return out;
}

/// The link of a rigid body that carries its shape, for each link; -1: none.
std::vector<int> carriers(const RobotModel& model) {
  std::vector<int> body(model.links.size(), -1), out(model.links.size(), -1);
  const auto root_of = [&](int link) {
    for (;;) {
      const int joint = model.links[static_cast<std::size_t>(link)].parent_joint;
      if (joint < 0 || model.joints[static_cast<std::size_t>(joint)].moves()) return link;
      link = model.joints[static_cast<std::size_t>(joint)].parent_link;
    }
  };
  for (const int link : shapes::links_with_shapes(model))
    body[static_cast<std::size_t>(root_of(link))] = link;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = body[static_cast<std::size_t>(root_of(static_cast<int>(i)))];
  return out;
}

/// Throws if the bounds of a link's meshes are not those that the catalogue has for it: another robot.
void check_size(const description::Link& link, const meshes::Mesh& mesh, double most) {
  if (!link.outline || mesh.empty()) return;
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (const meshes::MeshPart& part : mesh)
    for (const auto& p : part.positions) {
      low = {std::min<double>(low.x, p[0]), std::min<double>(low.y, p[1]), std::min<double>(low.z, p[2])};
      high = {std::max<double>(high.x, p[0]), std::max<double>(high.y, p[1]), std::max<double>(high.z, p[2])};
    }
  const double off = std::max(norm(low - link.outline->lower), norm(high - link.outline->upper));
  if (off > most)
    throw Error("other-robot",
                fmt::format("the meshes of {} reach {:.0f} mm further or less far than the robot file says",
                            link.name, 1000 * off),
                "state the arguments of this model (NAME:=VALUE)");
}

/// All shapes whose files are there.
meshes::Mesh mesh_of(const std::vector<Shape>& shapes) {
  meshes::Mesh out;
  for (const Shape& shape : shapes) {
    if (shape.kind == ShapeKind::mesh && shape.mesh_path.empty()) continue;
    meshes::Mesh one =
        shape.kind == ShapeKind::mesh ? meshes::read_mesh(shape.mesh_path) : meshes::mesh_of_shape(shape);
    meshes::place(one, shape);
    std::move(one.begin(), one.end(), std::back_inserter(out));
  }
  return out;
}

/// True if the files give their surfaces several colours that mean something.
bool has_colors(const std::map<int, meshes::Mesh>& all) {
  std::optional<std::array<float, 4>> first;
  for (const auto& [body, mesh] : all)
    for (const meshes::MeshPart& part : mesh) {
      if (!part.colored) continue;
      if (!first) first = part.color;
      for (std::size_t k = 0; k < 3; ++k)
        if (std::abs((*first)[k] - part.color[k]) > 0.15f) return true;
    }
  return false;
}

/// The effort that goes into a measured look. Later ones are tried if earlier ones are not close enough.
struct Detail {
  std::size_t pieces, characters;  ///< of a link, at most
  double tolerance;                ///< relative to the reach
};
constexpr std::array kDetails = {Detail{11, 3500, 0.0022}, Detail{18, 6000, 0.0015}};
constexpr double kCloseEnough = 0.0098;  // of the reach: 95 % of the surfaces

shapes::MeasuredLook look_of(const RobotModel& model, const MeshedRobot& of, const Detail& detail,
                             bool with_colors) {
  FitOptions options;
  options.most_pieces = detail.pieces;
  options.most_text = detail.characters;
  options.tolerance = std::clamp(detail.tolerance * of.reach, 0.0005, 0.005);
  options.smallest = 0.012 * of.reach;
  options.with_colors = with_colors;
  meshes::Mesh whole;
  for (const auto& [body, mesh] : of.bodies) whole.insert(whole.end(), mesh.begin(), mesh.end());
  options.main_color = main_color(whole);
  shapes::MeasuredLook out;
  for (const auto& [body, mesh] : of.bodies)
    for (shapes::MeasuredLoft& loft :
         fit_look(mesh, model.links[static_cast<std::size_t>(body)].name, options))
      out.lofts.push_back(std::move(loft));
  return out;
}

}  // namespace

namespace {

/// True if all links that move are there under their names, and the joints are at the same places relative to
/// each other and to the link that the first of them is fixed to.
bool has_same_joints(const RobotModel& model, const MeshedRobot& ours, const std::vector<std::string>& names,
                     const std::vector<Pose>& theirs) {
  constexpr double kSame = 0.005;  // of the reach
  std::optional<Pose> to_ours;
  const auto is_same = [&](int link, bool needed) {
    const auto at = static_cast<std::size_t>(link);
    const auto found = std::find(names.begin(), names.end(), model.links[at].name);
    if (found == names.end()) return !needed;
    const Pose& their = theirs[static_cast<std::size_t>(found - names.begin())];
    if (!to_ours) to_ours = ours.links[at] * inverse(their);
    return norm((*to_ours * their).position - ours.links[at].position) <= kSame * ours.reach;
  };
  for (const description::Joint& joint : model.joints)
    if (joint.moves() && (!is_same(joint.parent_link, false) || !is_same(joint.child_link, true)))
      return false;
  return to_ours.has_value();
}

/// The links that move one after the other, from the base to the tool, behind the link that the first joint
/// is fixed to.
std::vector<int> moving_chain(const RobotModel& model) {
  std::vector<int> out;
  int base = -1;
  for (int link = model.tool_link(); link >= 0;) {
    const int joint = model.links[static_cast<std::size_t>(link)].parent_joint;
    if (joint < 0) break;
    const description::Joint& each = model.joints[static_cast<std::size_t>(joint)];
    link = each.parent_link;
    if (!each.moves()) continue;
    out.push_back(each.child_link);
    base = each.parent_link;
  }
  out.push_back(base);
  std::reverse(out.begin(), out.end());
  return out;
}

/// Gives links that stand in the same order at the same places, in the same frames, the names of `model`:
/// others name the links of the same robot in other ways.
void name_by_order(const RobotModel& model, const RobotModel& meshed, std::vector<std::string>& names) {
  constexpr double kSame = 0.002, kSameTurn = 0.01;  // of the reach; rad
  const std::vector<int> ours = moving_chain(model), theirs = moving_chain(meshed);
  if (ours.size() != theirs.size() || ours.size() < 3) return;
  const auto known = [&](int link) {
    return std::find(names.begin(), names.end(), model.links[static_cast<std::size_t>(link)].name) !=
           names.end();
  };
  if (std::all_of(ours.begin() + 1, ours.end(), known)) return;
  const std::vector<Pose> our_poses = posed(model, model.joint_names(), {}),
                          their_poses = posed(meshed, meshed.joint_names(), {});
  const auto place = [](const std::vector<Pose>& poses, const std::vector<int>& chain, std::size_t i) {
    return inverse(poses[static_cast<std::size_t>(chain[0])]) * poses[static_cast<std::size_t>(chain[i])];
  };
  const double reach = model.provenance.reach_m.value_or(1);
  for (std::size_t i = 1; i < ours.size(); ++i) {
    const Pose off = inverse(place(our_poses, ours, i)) * place(their_poses, theirs, i);
    if (norm(off.position) > kSame * reach || angle_between(off.rotation, {}) > kSameTurn) return;
  }
  for (std::size_t i = 0; i < ours.size(); ++i)
    names[static_cast<std::size_t>(theirs[i])] = model.links[static_cast<std::size_t>(ours[i])].name;
}

}  // namespace

MeshedRobot meshes_of(const RobotModel& model, const RobotModel& meshed, double most_off) {
  std::map<std::string, double> home;
  const std::vector<double> start = model.start();
  for (std::size_t i = 0; i < start.size(); ++i) home[model.joint_names()[i]] = start[i];
  const std::vector<std::string> joints = model.joint_names(), links = link_names(model);
  MeshedRobot out{{}, posed(model, joints, home), model.provenance.reach_m.value_or(1)};
  const std::vector<std::string> their_joints = meshed.joint_names(), their_links = link_names(meshed);
  const std::vector<Pose> theirs =
      posed(meshed, without(prefix_of(their_joints, joints), their_joints), home);
  std::vector<std::string> names = without(prefix_of(their_links, links), their_links);
  name_by_order(model, meshed, names);
  if (has_same_joints(model, out, names, theirs)) most_off *= kSameJoints;
  const std::vector<int> carrier = carriers(model);
  for (std::size_t i = 0; i < meshed.links.size(); ++i) {
    int known = static_cast<int>(i);
    while (known >= 0 && model.find_link(names[static_cast<std::size_t>(known)]) < 0) {
      const int joint = meshed.links[static_cast<std::size_t>(known)].parent_joint;
      const bool fixed = joint >= 0 && !meshed.joints[static_cast<std::size_t>(joint)].moves();
      known = fixed ? meshed.joints[static_cast<std::size_t>(joint)].parent_link : -1;
    }
    if (known < 0) continue;
    const int link = model.find_link(names[static_cast<std::size_t>(known)]),
              body = carrier[static_cast<std::size_t>(link)];
    if (body < 0) continue;
    meshes::Mesh whole = mesh_of(meshed.links[i].visuals);
    if (whole.empty()) whole = mesh_of(meshed.links[i].collisions);
    if (whole.empty()) continue;
    if (known == static_cast<int>(i))
      check_size(model.links[static_cast<std::size_t>(link)], whole, most_off * out.reach);
    Shape at_body;
    at_body.pose = inverse(out.links[static_cast<std::size_t>(body)]) *
                   out.links[static_cast<std::size_t>(link)] *
                   inverse(theirs[static_cast<std::size_t>(known)]) * theirs[i];
    meshes::place(whole, at_body);
    std::move(whole.begin(), whole.end(), std::back_inserter(out.bodies[body]));
  }
  if (out.bodies.empty())
    throw Error("no-mesh", "the description has no mesh on a link that '" + model.name + "' has",
                "name the folder of its package in POLYARM_PACKAGES");
  return out;
}

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double Comparison::p95() const {
  return std::max(at_share(there, 0.95), at_share(back, 0.95));
}

double Comparison::largest() const {
  return std::max(there.back(), back.back());
}

Comparison compare(const RobotModel& model, const MeshedRobot& to, Problems& warnings) {
  std::vector<Triangle> look, mesh;
  for (const shapes::LinkShape& each : shapes::robot_shapes(model, warnings))
    if (to.bodies.contains(each.link))
      place_into(look, each.mesh, to.links[static_cast<std::size_t>(each.link)]);
  for (const auto& [body, each] : to.bodies) place_into(mesh, each, to.links[static_cast<std::size_t>(body)]);
  if (look.empty() || mesh.empty())
    throw Error("no-mesh", "the meshes or the look have no triangles",
                "name a description with meshes of the robot");
  Comparison out{mesh.size(), look.size(), distances(look, mesh), distances(mesh, look)};
  if (out.there.empty() || out.back.empty())
    throw Error("no-mesh", "no surface of the meshes or of the look is visible from outside",
                "check the meshes and their units");
  return out;
}

Comparison measure(RobotModel model, const MeshedRobot& of, const MeasureOptions& options,
                   Problems& warnings) {
  for (const int link : shapes::links_with_shapes(model))
    if (!of.bodies.contains(link))
      throw Error("no-mesh",
                  "the description has no mesh for " + model.links[static_cast<std::size_t>(link)].name,
                  "every moving link needs one");
  const bool with_colors = !options.plain && has_colors(of.bodies);
  Comparison out;
  for (const Detail& detail : kDetails) {
    shapes::MeasuredLook look = look_of(model, of, detail, with_colors);
    look.source = options.source;
    write_file_atomically(options.file, shapes::text_of(look));
    shapes::read_measured_look(options.file);  // an error if it cannot be read: meshes in mm are too large
    model.look[description::kMeasuredLook] = options.file;
    out = compare(model, of, warnings);
    if (out.p95() < kCloseEnough * of.reach) break;
  }
  return out;
}

}  // namespace polyarm::fitting
