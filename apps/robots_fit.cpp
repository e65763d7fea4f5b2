#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "apps/options.hpp"
#include "apps/robots.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/fitting/fit_look.hpp"
#include "polyarm/hulls/triangle_tree.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/shapes/robot_shapes.hpp"

namespace polyarm::apps {

namespace {

using description::RobotModel;
using description::Shape;
using description::ShapeKind;
using hulls::Triangle;

constexpr int kSamples = 4'000;
constexpr double kOtherRobot = 0.06;  // of the reach; larger differences of size mean another model
constexpr double kOff = 2e-4;  // m; visibility is judged this far off a surface

/// Adds the triangles of a mesh, moved by `pose`.
void place_into(std::vector<Triangle>& out, const meshes::Mesh& mesh, const Pose& pose) {
  for (const Triangle& t : fitting::surface_of(mesh)) out.push_back({pose * t[0], pose * t[1], pose * t[2]});
}

struct Posed {
  std::vector<Pose> links;  ///< in the world
};

/// Joints take the values of `by_name`, others zero.
Posed posed(const RobotModel& model, const std::map<std::string, double>& by_name) {
  std::vector<double> q;
  for (const std::string& name : model.joint_names())
    q.push_back(by_name.contains(name) ? by_name.at(name) : 0);
  Posed out{std::vector<Pose>(model.links.size())};
  kinematics::Chain(model, model.tool_link()).link_poses(q, out.links);
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
    const Vec3 normal = normalized(cross(t[1] - t[0], t[2] - t[0]));
    const Vec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    if (fitting::is_visible(tree, p + kOff * normal) || fitting::is_visible(tree, p - kOff * normal))
      out.push_back(p);
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

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
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

/// The meshes of a description, by the link of the catalogue's robot whose body they belong to and in its
/// frame. A link that the catalogue does not have belongs to the body of the next link above that it has. A
/// link without meshes to look at has those that it collides with. `most_off`: see check_size, m.
std::map<int, meshes::Mesh> meshes_by_body(const RobotModel& model, const Posed& ours,
                                           const RobotModel& meshed, const Posed& theirs, double most_off) {
  const std::vector<int> carrier = carriers(model);
  std::map<int, meshes::Mesh> out;
  for (std::size_t i = 0; i < meshed.links.size(); ++i) {
    int known = static_cast<int>(i);
    while (known >= 0 && model.find_link(meshed.links[static_cast<std::size_t>(known)].name) < 0) {
      const int joint = meshed.links[static_cast<std::size_t>(known)].parent_joint;
      const bool fixed = joint >= 0 && !meshed.joints[static_cast<std::size_t>(joint)].moves();
      known = fixed ? meshed.joints[static_cast<std::size_t>(joint)].parent_link : -1;
    }
    if (known < 0) continue;
    const int link = model.find_link(meshed.links[static_cast<std::size_t>(known)].name),
              body = carrier[static_cast<std::size_t>(link)];
    if (body < 0) continue;
    const Pose at = inverse(ours.links[static_cast<std::size_t>(body)]) *
                    ours.links[static_cast<std::size_t>(link)] *
                    inverse(theirs.links[static_cast<std::size_t>(known)]) * theirs.links[i];
    meshes::Mesh whole = mesh_of(meshed.links[i].visuals);
    if (whole.empty()) whole = mesh_of(meshed.links[i].collisions);
    if (known == static_cast<int>(i))
      check_size(model.links[static_cast<std::size_t>(link)], whole, most_off);
    for (meshes::MeshPart& part : whole) {
      for (auto& p : part.positions) {
        const Vec3 moved = at * Vec3{p[0], p[1], p[2]};
        p = {static_cast<float>(moved.x), static_cast<float>(moved.y), static_cast<float>(moved.z)};
      }
      part.normals.clear();
      part.texcoords.clear();
      out[body].push_back(std::move(part));
    }
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

/// The description that is measured, and its meshes by the bodies of the catalogue's robot.
struct Measured {
  std::map<int, meshes::Mesh> bodies;
  Posed at;  ///< where the catalogue's robot stands while both are compared
  double reach = 1;
  bool with_colors = false;
};

shapes::MeasuredLook measure(const RobotModel& model, const Measured& of, const Detail& detail) {
  fitting::FitOptions options;
  options.most_pieces = detail.pieces;
  options.most_text = detail.characters;
  options.tolerance = std::clamp(detail.tolerance * of.reach, 0.0005, 0.005);
  options.smallest = 0.012 * of.reach;
  options.with_colors = of.with_colors;
  meshes::Mesh whole;
  for (const auto& [body, mesh] : of.bodies) whole.insert(whole.end(), mesh.begin(), mesh.end());
  options.main_color = fitting::main_color(whole);
  shapes::MeasuredLook out;
  for (const auto& [body, mesh] : of.bodies)
    for (shapes::MeasuredLoft& loft :
         fitting::fit_look(mesh, model.links[static_cast<std::size_t>(body)].name, options))
      out.lofts.push_back(std::move(loft));
  return out;
}

/// How far the look of a robot and the meshes of its description are from each other.
struct Comparison {
  std::size_t mesh_triangles = 0, look_triangles = 0;
  std::vector<double> there, back;  ///< look to meshes, meshes to look, m, in ascending order
  double p95() const { return std::max(at_share(there, 0.95), at_share(back, 0.95)); }
  double largest() const { return std::max(there.back(), back.back()); }
};

Comparison compare(const RobotModel& model, const Measured& to) {
  std::vector<Triangle> look, mesh;
  Problems warnings;
  for (const shapes::LinkShape& each : shapes::robot_shapes(model, warnings))
    if (to.bodies.contains(each.link))
      place_into(look, each.mesh, to.at.links[static_cast<std::size_t>(each.link)]);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  for (const auto& [body, each] : to.bodies)
    place_into(mesh, each, to.at.links[static_cast<std::size_t>(body)]);
  if (look.empty() || mesh.empty())
    throw Error("no-mesh", "the meshes or the look have no triangles", "name a description with meshes of the robot");
  Comparison out{mesh.size(), look.size(), distances(look, mesh), distances(mesh, look)};
  if (out.there.empty() || out.back.empty())
    throw Error("no-mesh", "no surface of the meshes or of the look is visible from outside",
                "check the meshes and their units");
  return out;
}

/// Throws if a body has no mesh: next to measured surfaces its made-up ones would not fit.
void check_whole(const RobotModel& model, const Measured& of) {
  for (const int link : shapes::links_with_shapes(model))
    if (!of.bodies.contains(link))
      throw Error("no-mesh",
                  "the description has no mesh for " + model.links[static_cast<std::size_t>(link)].name,
                  "every moving link needs one");
}

/// Writes the measured look to the file, and again in more detail while it is not close enough.
Comparison measure_into(const std::string& file, const std::string& source, RobotModel& model,
                        const Measured& of) {
  check_whole(model, of);
  Comparison out;
  for (const Detail& detail : kDetails) {
    shapes::MeasuredLook look = measure(model, of, detail);
    look.source = source;
    write_file_atomically(file, shapes::text_of(look));
    shapes::read_measured_look(file);  // an error if no cell could read it: meshes in millimetres are too large
    model.look[description::kMeasuredLook] = file;
    out = compare(model, of);
    if (out.p95() < kCloseEnough * of.reach) break;
  }
  return out;
}

void print(const Comparison& fit, double reach) {
  fmt::print("meshes: {} triangles, look: {} triangles\n", fit.mesh_triangles, fit.look_triangles);
  fmt::print("look to meshes: half of it within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * at_share(fit.there, 0.5), 1000 * at_share(fit.there, 0.95));
  fmt::print("meshes to look: half of them within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * at_share(fit.back, 0.5), 1000 * at_share(fit.back, 0.95));
  fmt::print("95 %: {:.1f} % of the reach, {:.3g} m\n", 100 * fit.p95() / reach, reach);
}

}  // namespace

int run_robots_fit(int argc, char** argv) {
  CommandLine app(
      "Compares the look of a robot of the catalogue with the meshes of a description, or measures it",
      "polyarm robots fit");
  RobotOption robot, other;
  std::string out_file, source;
  bool line = false, plain = false;
  app.add_option("robot", robot.name, "a robot of the catalogue")->required();
  app.add_option("description", other.name, "a URDF or xacro with visual meshes of the same robot")
      ->required();
  app.add_option("arguments", other.arguments, "NAME:=VALUE of a description in xacro");
  app.add_option("--out", out_file,
                 "measures the surfaces of the meshes and writes them: MODEL.look beside a robot file");
  app.add_option("--source", source, "where the meshes are from, for the file");
  app.add_flag("--plain", plain, "colours of the maker's style instead of those of the meshes");
  app.add_flag("--csv", line,
               "one line: name, triangles of the meshes and of the look, reach, p95, largest (m)");
  app.footer(examples({"polyarm robots fit universal_robots/ur5e ur5e.urdf",
                       "polyarm robots fit universal_robots/ur5e ur.urdf.xacro name:=ur ur_type:=ur5e",
                       "polyarm robots fit robots/a6.yaml a6.urdf --out robots/a6.look"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems warnings;
  const description::Catalogue catalogue = open_catalogue();
  RobotModel model = robot.load(warnings, catalogue);
  const RobotModel meshed = other.load(warnings, catalogue);

  std::map<std::string, double> state;
  const std::vector<double> start = model.start();
  for (std::size_t i = 0; i < start.size(); ++i) state[model.joint_names()[i]] = start[i];
  Measured measured;
  measured.reach = model.provenance.reach_m.value_or(1);
  measured.at = posed(model, state);
  const double most_off =
      out_file.empty() ? std::numeric_limits<double>::infinity() : kOtherRobot * measured.reach;
  measured.bodies = meshes_by_body(model, measured.at, meshed, posed(meshed, state), most_off);
  if (measured.bodies.empty())
    throw Error("no-mesh", "the description has no mesh on a link that '" + model.name + "' has",
                "name the folder of its package in POLYARM_PACKAGES");
  measured.with_colors = !plain && has_colors(measured.bodies);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  const Comparison fit =
      out_file.empty() ? compare(model, measured) : measure_into(out_file, source, model, measured);
  if (line)
    fmt::print("{},{},{},{:.4g},{:.5f},{:.5f}\n", robot.name, fit.mesh_triangles, fit.look_triangles,
               measured.reach, fit.p95(), fit.largest());
  else
    print(fit, measured.reach);
  return kOk;
}

}  // namespace polyarm::apps
