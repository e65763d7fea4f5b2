#include "polyarm/meshes/robot_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "polyarm/base/bounds.hpp"
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
constexpr const char* kFormat = "meshes/2";
constexpr std::size_t kMostCached = bounds::kCachedMeshes;
/// All images of a robot, bytes.
constexpr std::size_t kMostRobotImages = bounds::kRobotImageBytes;

/// Leaves out images beyond kMostRobotImages bytes together.
class ImageBudget {
 public:
  void take(Mesh& mesh) {
    for (MeshPart& part : mesh) {
      if (!part.image || taken_.contains(*part.image)) continue;
      bytes_ += part.image->size();
      if (bytes_ > kMostRobotImages) {
        bytes_ -= part.image->size();
        part.image.reset();
        part.texcoords.clear();
      } else {
        taken_.insert(*part.image);
      }
    }
  }

 private:
  std::size_t bytes_ = 0;
  std::set<std::string> taken_;
};

double diagonal_of(const Mesh& mesh) {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const MeshPart& part : mesh)
    for (const auto& p : part.positions) {
      low = {std::min<double>(low.x, p[0]), std::min<double>(low.y, p[1]), std::min<double>(low.z, p[2])};
      high = {std::max<double>(high.x, p[0]), std::max<double>(high.y, p[1]), std::max<double>(high.z, p[2])};
    }
  return high.x < low.x ? 0 : norm(high - low);
}

/// `left`: triangles that the robot may still use.
Mesh mesh_of(const Link& link, std::size_t& left, Problems& notes) {
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
    Mesh mesh = read_mesh(shape.mesh_path, &notes);
    const std::size_t triangles = triangles_of(mesh);
    if (triangles > left) {
      left = 0;
      throw large();
    }
    left -= triangles;
    place(mesh, shape);
    if (const std::string doubt = doubt_of_size(diagonal_of(mesh)); !doubt.empty())
      notes.warning("mesh-size", {}, "the mesh " + shape.mesh_path + doubt, kUnitAdvice);
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

/// Gives each node its share of `most` triangles. A note says what was simplified.
void simplify_nodes(std::vector<GlbNode>& nodes, std::size_t most, std::vector<Problem>& notes) {
  std::size_t all = 0;
  for (const GlbNode& node : nodes) all += triangles_of(node.mesh);
  if (all <= most) return;
  std::size_t kept = 0;
  double moved = 0;
  for (GlbNode& node : nodes) {
    const double share = static_cast<double>(triangles_of(node.mesh)) / static_cast<double>(all);
    moved = std::max(moved,
                     simplify(node.mesh, static_cast<std::size_t>(share * static_cast<double>(most)) + 12));
    kept += triangles_of(node.mesh);
  }
  notes.push_back(
      {"large-mesh",
       {},
       fmt::format(
           "the meshes of this robot have {} triangles; {} are drawn, corners moved by at most {:.1f} mm",
           all, kept, 1000 * moved),
       "simplify them, if the picture needs finer ones",
       Severity::warning});
}

RobotMeshes convert(const RobotModel& model, std::size_t left, std::size_t drawn) {
  RobotMeshes out;
  std::vector<GlbNode> nodes;
  ImageBudget images;
  Problems notes;
  for (const Link& link : model.links) {
    if (!has_mesh(link)) continue;
    try {
      nodes.push_back({link.name, mesh_of(link, left, notes)});
      images.take(nodes.back().mesh);
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.what = "the link '" + link.name + "' is shown by what it collides with: " + problem.what;
      problem.severity = Severity::warning;
      out.warnings.push_back(std::move(problem));
      nodes.push_back({link.name, collision_mesh_of(link)});
    }
  }
  out.notes = notes.list();
  simplify_nodes(nodes, drawn, out.notes);
  out.glb = write_glb(nodes);
  return out;
}

}  // namespace

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

RobotMeshes robot_meshes(const RobotModel& model, const fs::path& cache, std::size_t most_triangles,
                         std::size_t drawn) {
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
  RobotMeshes out = convert(model, most_triangles, drawn);
  if (!cache.empty() && out.warnings.empty()) store_in_cache(path, out.glb, kMostCached, 0644);
  return out;
}

}  // namespace polyarm::meshes
