#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>

#include "apps/options.hpp"
#include "apps/robots.hpp"
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

constexpr int kSamples = 20'000;

/// All triangles of a robot in the frame of one of its links, in one joint state.
std::vector<Triangle> placed(const meshes::Mesh& mesh, const Pose& pose, std::vector<Triangle> out) {
  for (const meshes::MeshPart& part : mesh)
    for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = part.positions[part.triangles[i + k]];
        triangle[k] = pose * Vec3{p[0], p[1], p[2]};
      }
      out.push_back(triangle);
    }
  return out;
}

struct Posed {
  std::vector<Pose> links;  ///< in the world
  const RobotModel* model;
  /// The pose of the link with this name; empty if no link has it.
  std::optional<Pose> of(const std::string& name) const {
    for (std::size_t i = 0; i < model->links.size(); ++i)
      if (model->links[i].name == name) return links[i];
    return std::nullopt;
  }
};

/// Joints take the values of `by_name`, others zero.
Posed posed(const RobotModel& model, const std::map<std::string, double>& by_name) {
  std::vector<double> q;
  for (const std::string& name : model.joint_names())
    q.push_back(by_name.contains(name) ? by_name.at(name) : 0);
  Posed out{std::vector<Pose>(model.links.size()), &model};
  kinematics::Chain(model, model.tool_link()).link_poses(q, out.links);
  return out;
}

/// Points by area.
std::vector<Vec3> samples(const std::vector<Triangle>& triangles) {
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
    out.push_back(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]));
  }
  return out;
}

std::vector<double> distances(const std::vector<Triangle>& from, const std::vector<Triangle>& to) {
  const hulls::TriangleTree tree(to);
  std::vector<double> out;
  for (const Vec3& p : samples(from)) out.push_back(tree.distance(p));
  std::sort(out.begin(), out.end());
  return out;
}

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

int run_robots_fit(int argc, char** argv) {
  CommandLine app("Compares the generated look of a robot of the catalogue with the meshes of a description",
                  "polyarm robots fit");
  RobotOption robot, other;
  bool line = false;
  app.add_option("robot", robot.name, "a robot of the catalogue")->required();
  app.add_option("description", other.name, "a URDF or xacro with visual meshes of the same robot")
      ->required();
  app.add_option("arguments", other.arguments, "NAME:=VALUE of a description in xacro");
  app.add_flag("--csv", line,
               "one line: name, triangles of the meshes and of the look, reach, p95, largest (m)");
  app.footer(examples({"polyarm robots fit universal_robots/ur5e ur5e.urdf",
                       "polyarm robots fit universal_robots/ur5e ur.urdf.xacro name:=ur ur_type:=ur5e"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems warnings;
  const description::Catalogue catalogue = open_catalogue();
  const RobotModel model = robot.load(warnings, catalogue), meshed = other.load(warnings, catalogue);

  std::map<std::string, double> state;
  const std::vector<double> start = model.start();
  for (std::size_t i = 0; i < start.size(); ++i) state[model.joint_names()[i]] = start[i];
  const Posed ours = posed(model, state), theirs = posed(meshed, state);

  std::vector<Triangle> look, mesh;
  Problems ignored;
  for (const shapes::LinkShape& each : shapes::robot_shapes(model, ignored))
    look = placed(each.mesh, ours.links[static_cast<std::size_t>(each.link)], std::move(look));
  for (std::size_t i = 0; i < meshed.links.size(); ++i)
    for (const Shape& shape : meshed.links[i].visuals) {
      // Each link of theirs stands where ours of that name is, so that only shapes are compared.
      const std::optional<Pose> at = ours.of(meshed.links[i].name);
      if (shape.kind != ShapeKind::mesh || shape.mesh_path.empty() || !at) continue;
      meshes::Mesh one = meshes::read_mesh(shape.mesh_path);
      meshes::place(one, shape);
      mesh = placed(one, *at, std::move(mesh));
    }
  if (mesh.empty())
    throw Error("no-mesh", "the description has no mesh on a link that '" + model.name + "' has",
                "name the folder of its package in POLYARM_PACKAGES");
  const std::vector<double> there = distances(look, mesh), back = distances(mesh, look);
  const double p95 = std::max(at_share(there, 0.95), at_share(back, 0.95)),
               largest = std::max(there.back(), back.back());
  double reach = 0;
  for (const description::CatalogueEntry& entry : catalogue.entries())
    if (entry.name == robot.name) reach = entry.reach_m.value_or(0);
  if (line) {
    fmt::print("{},{},{},{:.4g},{:.5f},{:.5f}\n", robot.name, mesh.size(), look.size(), reach, p95, largest);
    return kOk;
  }
  fmt::print("meshes: {} triangles, look: {} triangles\n", mesh.size(), look.size());
  fmt::print("look to meshes: half of it within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * at_share(there, 0.5), 1000 * at_share(there, 0.95));
  fmt::print("meshes to look: half of them within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * at_share(back, 0.5), 1000 * at_share(back, 0.95));
  if (reach > 0) fmt::print("95 %: {:.1f} % of the reach, {:.3g} m\n", 100 * p95 / reach, reach);
  return kOk;
}

}  // namespace polyarm::apps
