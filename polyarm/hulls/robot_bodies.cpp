#include "polyarm/hulls/robot_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "polyarm/base/cache.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/hulls/convex_pieces.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/sha256.hpp"

namespace polyarm::hulls {

namespace fs = std::filesystem;
using description::Shape;
using description::ShapeKind;

namespace {

/// Change this whenever the pieces of the same mesh change.
constexpr std::string_view kFormat = "polyarm-bodies/1";
constexpr std::size_t kMostCached = 512;
constexpr std::size_t kLargestCached = 4 << 20;  // bytes

struct Body {
  std::vector<std::vector<Vec3>> pieces;
  BodyReport report;
};

Body computed(const Shape& shape) {
  const std::vector<Triangle> triangles = surface_of(meshes::read_mesh(shape.mesh_path), shape.scale);
  const ConvexPieces made = convex_pieces(triangles);
  Body out;
  for (const Hull& hull : made.pieces) out.pieces.push_back(hull.corners);
  out.report = {shape.mesh_path,
                triangles.size(),
                made.pieces.size(),
                made.size,
                made.mean_excess,
                made.largest_excess,
                false};
  return out;
}

// --- the cache

std::string to_text(const Body& body) {
  std::string out =
      fmt::format("{}\n{} {} {:.9g} {:.9g} {:.9g}\n", kFormat, body.report.triangles, body.pieces.size(),
                  body.report.size, body.report.mean_excess, body.report.largest_excess);
  for (const auto& piece : body.pieces) {
    out += fmt::format("{}\n", piece.size());
    for (const Vec3& p : piece) out += fmt::format("{:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
  }
  return out + "end\n";
}

/// Reads numbers separated by spaces. `good` becomes false at the first word that is not a number or is too
/// large.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : text_(text) {}
  double number(double most) {
    while (!text_.empty() && (text_.front() == ' ' || text_.front() == '\n')) text_.remove_prefix(1);
    double out = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), out);
    if (error != std::errc() || !(out >= -most && out <= most)) {
      good = false;
      return 0;
    }
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return out;
  }
  std::size_t count(std::size_t most) {
    const double out = number(static_cast<double>(most));
    if (out < 0) good = false;
    return good ? static_cast<std::size_t>(out) : 0;
  }
  std::string_view rest() const { return text_; }
  bool good = true;

 private:
  std::string_view text_;
};

/// Returns false if the text is not a complete body.
bool from_text(std::string_view text, Body& out) {
  const std::string first = std::string(kFormat) + "\n";
  if (!text.starts_with(first)) return false;
  Numbers in(text.substr(first.size()));
  const PieceOptions bounds;
  out.report.triangles = in.count(meshes::kMostTriangles);
  const std::size_t pieces = in.count(bounds.most_pieces);
  out.report.size = in.number(1e7);
  out.report.mean_excess = in.number(1e7);
  out.report.largest_excess = in.number(1e7);
  for (std::size_t i = 0; i < pieces && in.good; ++i) {
    std::vector<Vec3> piece;
    for (std::size_t n = in.count(bounds.most_corners); n > 0 && in.good; --n) {
      const double x = in.number(1e7), y = in.number(1e7), z = in.number(1e7);
      piece.push_back({x, y, z});
    }
    if (piece.size() < 4) return false;
    out.pieces.push_back(std::move(piece));
  }
  out.report.pieces = pieces;
  out.report.cached = true;
  return in.good && pieces > 0 && in.rest() == "\nend\n";
}

fs::path place_in(const fs::path& cache, const Shape& shape) {
  const std::string bytes = read_file(shape.mesh_path, meshes::kLargestFile);
  const std::string key = fmt::format("{} {} {:a} {:a} {:a}", kFormat, sha256(bytes), shape.scale.x,
                                      shape.scale.y, shape.scale.z);
  return cache / (sha256(key).substr(0, 32) + ".body");
}

bool take(const fs::path& path, Body& out) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::string text;
  Problems ignored;
  collect(ignored, [&] { text = read_file(path, kLargestCached); });
  Body body;
  if (!from_text(text, body)) return false;
  out = std::move(body);
  return true;
}

bool take_cached(const Shape& shape, const fs::path& cache, Body& out) {
  if (cache.empty()) return false;
  const fs::path path = place_in(cache, shape);
  const AsUser as_user;
  if (!take(path, out)) return false;
  out.report.mesh = shape.mesh_path;
  return true;
}

Body made(const Shape& shape, const fs::path& cache) {
  Body out = computed(shape);
  if (cache.empty()) return out;
  const fs::path path = place_in(cache, shape);
  const AsUser as_user;
  if (const std::string text = to_text(out); text.size() <= kLargestCached)
    store_in_cache(path, text, kMostCached, 0600);
  return out;
}

// --- several bodies

/// Shapes with the same mesh and scale, and therefore the same body.
struct Job {
  std::vector<Shape*> shapes;
  Body body;
  Problems problems;
  bool done = false;  ///< found in the cache, or failed
};

std::function<void(std::size_t, std::size_t)>& listener_to_making() {
  static std::function<void(std::size_t, std::size_t)> listener;
  return listener;
}

std::vector<Job> jobs_of(const std::vector<Shape*>& shapes) {
  std::map<std::string, Job> by_mesh;
  for (Shape* shape : shapes)
    if (shape->kind == ShapeKind::mesh)
      by_mesh[fmt::format("{}|{}|{:a} {:a} {:a}", shape->mesh, shape->mesh_path, shape->scale.x,
                          shape->scale.y, shape->scale.z)]
          .shapes.push_back(shape);
  std::vector<Job> out;
  for (auto& [key, job] : by_mesh) out.push_back(std::move(job));
  return out;
}

/// Removes the jobs whose mesh file was not found, and adds one warning for all of them.
void warn_of_missing(std::vector<Job>& jobs, std::vector<Problem>& warnings) {
  std::vector<std::string> missing;
  std::erase_if(jobs, [&](const Job& job) {
    if (job.shapes.front()->mesh_path.empty()) missing.push_back(job.shapes.front()->mesh);
    return job.shapes.front()->mesh_path.empty();
  });
  if (missing.empty()) return;
  const std::string what = missing.size() == 1 ? "the mesh " + missing[0] + " was not found"
                                               : fmt::format("{} meshes were not found, the first is {}",
                                                             missing.size(), missing[0]);
  warnings.push_back(
      {"no-mesh", {}, what, "give the folder of their package in POLYARM_PACKAGES", Severity::warning});
}

/// Calls `step` for each job, in parallel on all processors.
template <typename Step>
void for_each(std::vector<Job>& jobs, Step step) {
  std::atomic<std::size_t> next{0};
  const bool as_user = AsUser::active();
  const auto work = [&] {
    std::optional<AsUser> user;
    if (as_user) user.emplace();
    for (std::size_t i = next++; i < jobs.size(); i = next++) try {
        collect(jobs[i].problems, [&] { step(jobs[i]); });
        if (jobs[i].problems.has_errors()) jobs[i].done = true;
      } catch (const std::exception& e) {
        jobs[i].done = true;
        jobs[i].problems.error("bad-mesh", {},
                               "no body for the mesh " + jobs[i].shapes.front()->mesh + ": " + e.what(),
                               "export it again with fewer triangles");
      }
  };
  const std::size_t workers =
      std::min<std::size_t>(std::max(1u, std::thread::hardware_concurrency()), jobs.size());
  std::vector<std::jthread> threads;  // joined at the end
  for (std::size_t i = 1; i < workers; ++i) threads.emplace_back(work);
  work();
}

void run(std::vector<Job>& jobs, const fs::path& cache) {
  for_each(jobs, [&](Job& job) { job.done = take_cached(*job.shapes.front(), cache, job.body); });
  const auto left = static_cast<std::size_t>(
      std::count_if(jobs.begin(), jobs.end(), [](const Job& job) { return !job.done; }));
  if (left == 0) return;
  std::mutex mutex;
  std::size_t ready = 0;
  const auto report = [&](std::size_t more) {
    const std::lock_guard lock(mutex);
    ready += more;
    if (listener_to_making()) listener_to_making()(ready, left);
  };
  report(0);
  for_each(jobs, [&](Job& job) {
    if (job.done) return;
    job.body = made(*job.shapes.front(), cache);
    report(1);
  });
}

}  // namespace

fs::path bodies_cache() {
  const fs::path folder = cache_folder();
  return folder.empty() ? folder : folder / "bodies";
}

void listen_to_making(std::function<void(std::size_t made, std::size_t meshes)> listener) {
  listener_to_making() = std::move(listener);
}

BodiesMade make_bodies(const std::vector<Shape*>& shapes, const fs::path& cache) {
  std::vector<Job> jobs = jobs_of(shapes);
  BodiesMade out;
  warn_of_missing(jobs, out.warnings);
  run(jobs, cache);
  for (Job& job : jobs) {
    for (Problem problem : job.problems.list()) {
      problem.severity = Severity::warning;
      out.warnings.push_back(std::move(problem));
    }
    if (job.body.pieces.empty()) continue;
    if (const std::string doubt = meshes::doubt_of_size(job.body.report.size); !doubt.empty())
      out.warnings.push_back({"mesh-size",
                              {},
                              "the mesh " + job.body.report.mesh + doubt,
                              meshes::kUnitAdvice,
                              Severity::warning});
    for (Shape* shape : job.shapes) shape->pieces = job.body.pieces;
    out.reports.push_back(std::move(job.body.report));
  }
  return out;
}

BodiesMade make_bodies(description::RobotModel& model, const fs::path& cache) {
  std::vector<Shape*> shapes;
  for (description::Link& link : model.links)
    for (Shape& shape : link.collisions) shapes.push_back(&shape);
  return make_bodies(shapes, cache);
}

}  // namespace polyarm::hulls
