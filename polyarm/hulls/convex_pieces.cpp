#include "polyarm/hulls/convex_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/hulls/best_cut.hpp"

namespace polyarm::hulls {

namespace {

constexpr std::size_t kSamples = 160;  // on each piece, to measure its excess
constexpr double kJoined = 1.01;       // largest volume of a joined piece's hull, relative to the volumes of
                                       // its parts
constexpr int kBlindCuts = 1;          // consecutive cuts that may save nothing
constexpr double kLeastPart = 0.02;    // smallest part that is cut off, relative to the extent

std::vector<Vec3> corners_of(const std::vector<Triangle>& triangles) {
  std::vector<Vec3> out;
  out.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles) out.insert(out.end(), triangle.begin(), triangle.end());
  const auto before = [](const Vec3& a, const Vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::sort(out.begin(), out.end(), before);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

double area_of(const Hull& hull, const std::array<std::uint32_t, 3>& face) {
  const Vec3& a = hull.corners[face[0]];
  return norm(cross(hull.corners[face[1]] - a, hull.corners[face[2]] - a)) / 2;
}

/// Points evenly spread over the surface of a hull; always the same points.
std::vector<Vec3> samples_on(const Hull& hull, std::size_t count) {
  double area = 0;
  for (const auto& face : hull.faces) area += area_of(hull, face);
  std::vector<Vec3> out;
  double passed = 0;
  for (const auto& face : hull.faces) {
    passed += area_of(hull, face);
    const Vec3 &a = hull.corners[face[0]], &b = hull.corners[face[1]], &c = hull.corners[face[2]];
    while (static_cast<double>(out.size()) + 0.5 < static_cast<double>(count) * passed / area &&
           out.size() < count) {
      // The additive recurrence of the plastic number (Roberts 2018) spreads points evenly.
      double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(out.size()), 1.0);
      double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(out.size()), 1.0);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      out.push_back(a + u * (b - a) + v * (c - a));
    }
  }
  return out;
}

/// True if another object can touch the point from outside: a ray from the point meets no triangle.
bool is_open(const TriangleTree& tree, const Vec3& point) {
  for (const double x : {-1.0, 0.013, 1.0})
    for (const double y : {-1.01, 0.017, 0.99})
      for (const double z : {-0.98, 0.011, 1.02}) {
        if (std::abs(x) < 0.1 && std::abs(y) < 0.1 && std::abs(z) < 0.1) continue;
        if (tree.escapes(point, {x, y, z})) return true;
      }
  return false;
}

struct Excess {
  double mean = 0, largest = 0, area = 0;
};

class Cutter {
 public:
  Cutter(const std::vector<Triangle>& triangles, const PieceOptions& options)
      : options_(options), tree_(triangles) {
    parts_.push_back(part(triangles));
    const Axes axes = principal_axes(parts_[0].hull.corners);
    for (std::size_t k = 0; k < 3; ++k) size_ = std::hypot(size_, axes.upper[k] - axes.lower[k]);
    least_cut_ = std::max(4 * kThinnest, kLeastPart * size_);
  }

  ConvexPieces run() {
    while (parts_.size() < options_.most_pieces && mean_excess() > options_.desired_excess * size_)
      if (!cut_worst()) break;
    merge();
    ConvexPieces out;
    for (Part& each : parts_) out.pieces.push_back(std::move(each.hull));
    out.size = size_;
    measure(out);
    return out;
  }

 private:
  struct Part {
    std::vector<Triangle> triangles;
    Hull hull;
    Excess excess;
    bool whole = false;  ///< no cut of this part helps
    int blind = 0;       ///< number of consecutive cuts before it that saved nothing
  };

  Part part(std::vector<Triangle> triangles) const {
    Part out;
    out.hull = enclosing_hull(corners_of(triangles), options_.most_corners);
    out.excess = excess_of(out.hull);
    out.triangles = std::move(triangles);
    return out;
  }

  Excess excess_of(const Hull& hull) const {
    Excess out;
    for (const auto& face : hull.faces) out.area += area_of(hull, face);
    const std::vector<Vec3> points = samples_on(hull, kSamples);
    for (const Vec3& point : points) {
      const double far = tree_.distance(point);
      if (far <= out.largest * 1e-3 || !is_open(tree_, point)) continue;
      out.mean += far / static_cast<double>(points.size());
      out.largest = std::max(out.largest, far);
    }
    return out;
  }

  double mean_excess() const {
    double sum = 0, area = 0;
    for (const Part& each : parts_) {
      sum += each.excess.mean * each.excess.area;
      area += each.excess.area;
    }
    return sum / area;
  }

  /// Cuts the part with the largest excess. Returns false if no cut of any part helps.
  bool cut_worst() {
    for (;;) {
      Part* worst = nullptr;
      const auto weight = [](const Part& each) { return each.excess.mean * each.excess.area; };
      for (Part& each : parts_)
        if (!each.whole && (!worst || weight(each) > weight(*worst))) worst = &each;
      if (!worst) return false;
      const BestCut best = best_cut(worst->triangles, worst->hull, least_cut_);
      const int blind = best.saves ? 0 : worst->blind + 1;
      if (best.plane.normal != Vec3{} && blind <= kBlindCuts) {
        Halves halves = cut(worst->triangles, best.plane);
        if (!halves.below.empty() && !halves.above.empty()) {
          Part below = part(std::move(halves.below)), above = part(std::move(halves.above));
          below.blind = above.blind = blind;
          *worst = std::move(below);
          parts_.push_back(std::move(above));
          return true;
        }
      }
      worst->whole = true;
    }
  }

  /// Joins pieces if the hull of both is hardly larger than the pieces.
  void merge() {
    for (std::size_t a = 0; a < parts_.size(); ++a)
      for (std::size_t b = a + 1; b < parts_.size();) {
        std::vector<Vec3> points = parts_[a].hull.corners;
        points.insert(points.end(), parts_[b].hull.corners.begin(), parts_[b].hull.corners.end());
        Hull joined = enclosing_hull(points, options_.most_corners);
        if (joined.volume > kJoined * (parts_[a].hull.volume + parts_[b].hull.volume)) {
          ++b;
          continue;
        }
        parts_[a].hull = std::move(joined);
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(b));
        b = a + 1;
      }
  }

  void measure(ConvexPieces& out) const {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < out.pieces.size(); ++i)
      for (const Vec3& point : samples_on(out.pieces[i], 2 * kSamples)) {
        ++count;
        const auto covers = [&](const Hull& other) {
          return &other != &out.pieces[i] && distance_outside(other, point) < -1e-6;
        };
        if (std::any_of(out.pieces.begin(), out.pieces.end(), covers) || !is_open(tree_, point)) continue;
        const double far = tree_.distance(point);
        sum += far;
        out.largest_excess = std::max(out.largest_excess, far);
      }
    out.mean_excess = count > 0 ? sum / static_cast<double>(count) : 0;
  }

  const PieceOptions& options_;
  TriangleTree tree_;
  std::vector<Part> parts_;
  double size_ = 0, least_cut_ = 0;
};

}  // namespace

ConvexPieces convex_pieces(const std::vector<Triangle>& triangles, const PieceOptions& options) {
  if (triangles.empty()) throw Error("bad-mesh", "the mesh has no triangle", "export it again");
  for (const Triangle& triangle : triangles)
    for (const Vec3& p : triangle)
      if (!(std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6 && std::abs(p.z) < 1e6))
        throw Error("bad-mesh", "a corner of the mesh is not finite or lies beyond 1,000 km",
                    "check its scale");
  return Cutter(triangles, options).run();
}

}  // namespace polyarm::hulls
