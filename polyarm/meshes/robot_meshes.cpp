#include "polyarm/meshes/robot_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "polyarm/base/cache.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/meshes/glb_writer.hpp"

namespace polyarm::meshes {

namespace fs = std::filesystem;
using description::Link;
using description::RobotModel;
using description::Shape;
using description::ShapeKind;

namespace {

/// Change it to invalidate all cached meshes.
constexpr const char* kFormat = "meshes/1";
constexpr std::size_t kMostCached = 32;

/// Scales the mesh and moves it to its pose in the link.
void place(Mesh& mesh, const Shape& shape) {
  const Vec3 s = shape.scale;
  const bool mirrors = s.x * s.y * s.z < 0;
  const auto inverse = [](double x) { return x != 0 ? 1 / x : 0; };
  for (MeshPart& part : mesh) {
    for (auto& p : part.positions) {
      const Vec3 at = shape.pose * Vec3{s.x * p[0], s.y * p[1], s.z * p[2]};
      p = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
    }
    for (auto& n : part.normals) {
      const Vec3 to = normalized(shape.pose.rotation *
                                 Vec3{inverse(s.x) * n[0], inverse(s.y) * n[1], inverse(s.z) * n[2]});
      n = {static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(to.z)};
    }
    for (std::size_t i = 0; mirrors && i + 2 < part.triangles.size(); i += 3)
      std::swap(part.triangles[i], part.triangles[i + 1]);
  }
}

std::size_t triangles_of(const Mesh& mesh) {
  std::size_t out = 0;
  for (const MeshPart& part : mesh) out += part.triangles.size() / 3;
  return out;
}

/// `left`: triangles that the robot may still use.
Mesh mesh_of(const Link& link, std::size_t& left) {
  Mesh out;
  for (const Shape& shape : link.visuals) {
    if (shape.kind != ShapeKind::mesh) continue;
    if (shape.mesh_path.empty())
      throw Error("no-mesh", "the mesh " + shape.mesh + " was not found",
                  "name its package's folder in POLYARM_PACKAGES");
    const auto large = [] {
      return Error("large-mesh", "the meshes of this robot have too many triangles together",
                   "simplify them: some thousand triangles are enough to draw them");
    };
    if (left == 0) throw large();  // without further reading
    Mesh mesh = read_mesh(shape.mesh_path);
    const std::size_t triangles = triangles_of(mesh);
    if (triangles > left) {
      left = 0;
      throw large();
    }
    left -= triangles;
    place(mesh, shape);
    for (MeshPart& part : mesh) out.push_back(std::move(part));
  }
  return out;
}

/// The collision geometry of a link, without meshes.
Mesh collision_mesh_of(const Link& link) {
  Mesh out;
  for (const Shape& shape : link.collisions) {
    Mesh mesh = mesh_of_shape(shape);
    place(mesh, shape);
    for (MeshPart& part : mesh) out.push_back(std::move(part));
  }
  return out;
}

RobotMeshes convert(const RobotModel& model, std::size_t left) {
  RobotMeshes out;
  std::vector<GlbNode> nodes;
  for (const Link& link : model.links) {
    if (!has_mesh(link)) continue;
    try {
      nodes.push_back({link.name, mesh_of(link, left)});
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.what = "the link '" + link.name + "' is shown by what it collides with: " + problem.what;
      problem.severity = Severity::warning;
      out.warnings.push_back(std::move(problem));
      nodes.push_back({link.name, collision_mesh_of(link)});
    }
  }
  out.glb = write_glb(nodes);
  return out;
}

}  // namespace

bool has_mesh(const Link& link) {
  return std::any_of(link.visuals.begin(), link.visuals.end(),
                     [](const Shape& shape) { return shape.kind == ShapeKind::mesh; });
}

std::string mesh_hash(const RobotModel& model) {
  if (std::none_of(model.links.begin(), model.links.end(), has_mesh)) return {};
  std::uint64_t h = 0xcbf29ce484222325u;
  const auto add = [&](const std::string& text) {
    for (const char c : text + '\n') h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  };
  add(kFormat);
  for (const Link& link : model.links)
    for (const Shape& shape : link.visuals) {
      if (shape.kind != ShapeKind::mesh) continue;
      std::error_code error;
      const auto size = fs::file_size(shape.mesh_path, error);
      const auto time = fs::last_write_time(shape.mesh_path, error).time_since_epoch().count();
      const Pose& p = shape.pose;
      add(fmt::format("{}|{}|{}|{}", link.name, shape.mesh_path, error ? 0 : size, error ? 0 : time));
      add(fmt::format("{} {} {} {} {} {} {} {} {} {}", p.position.x, p.position.y, p.position.z, p.rotation.x,
                      p.rotation.y, p.rotation.z, p.rotation.w, shape.scale.x, shape.scale.y, shape.scale.z));
    }
  return fmt::format("{:016x}", h);
}

RobotMeshes robot_meshes(const RobotModel& model, const fs::path& cache, std::size_t most_triangles) {
  const std::string hash = mesh_hash(model);
  if (hash.empty()) return {};
  const fs::path path = cache / (hash + ".glb");
  std::error_code error;
  if (!cache.empty() && fs::is_regular_file(path, error)) {
    RobotMeshes kept;
    Problems ignored;
    collect(ignored, [&] { kept.glb = read_file(path); });
    if (kept.glb.starts_with("glTF")) return kept;
  }
  RobotMeshes out = convert(model, most_triangles);
  if (!cache.empty() && out.warnings.empty()) store_in_cache(path, out.glb, kMostCached, 0644);
  return out;
}

}  // namespace polyarm::meshes
