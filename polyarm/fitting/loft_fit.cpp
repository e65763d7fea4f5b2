#include "polyarm/fitting/loft_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace polyarm::fitting {

using hulls::Hull;
using shapes::kTangents;
using shapes::MeasuredLoft;
using shapes::MeasuredSection;

namespace {

constexpr double kStep = 2 * std::numbers::pi / kTangents;
constexpr int kPlaces = 16;  // places along an axis that are looked at, beside those of corners
constexpr std::size_t kMostSections = 9;
constexpr double kNear = 3e-4;   // m; least distance of two sections
constexpr double kInset = 1e-3;  // of the length: the ends of a hull are looked at a little inside

using Extents = std::array<double, kTangents>;

/// A hull seen along an axis.
class Slices {
 public:
  Slices(const Hull& hull, const Pose& frame) : hull_(hull) {
    const Pose into = inverse(frame);
    for (const Vec3& corner : hull.corners) corners_.push_back(into * corner);
    const auto lower = [](const Vec3& a, const Vec3& b) { return a.z < b.z; };
    const auto [least, most] = std::minmax_element(corners_.begin(), corners_.end(), lower);
    from_ = least->z;
    to_ = most->z;
  }

  double from() const { return from_; }
  double to() const { return to_; }

  /// The points in which edges pass the plane at `at`.
  std::vector<Vec3> cut(double at) const {
    const double z = std::clamp(at, from_ + kInset * (to_ - from_), to_ - kInset * (to_ - from_));
    std::vector<Vec3> out;
    for (const auto& face : hull_.faces)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = corners_[face[k]], &b = corners_[face[(k + 1) % 3]];
        if ((a.z < z) == (b.z < z) || a.z > b.z) continue;  // each edge belongs to two faces
        out.push_back(a + (z - a.z) / (b.z - a.z) * (b - a));
      }
    return out;
  }

  Extents extents(double at) const {
    const std::vector<Vec3> points = cut(at);
    Extents out;
    out.fill(0);
    for (std::size_t k = 0; k < kTangents; ++k) {
      const double c = std::cos(kStep * static_cast<double>(k)), s = std::sin(kStep * static_cast<double>(k));
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double extent = points[i].x * c + points[i].y * s;
        out[k] = i == 0 ? extent : std::max(out[k], extent);
      }
    }
    return out;
  }

  /// Where a section may stand: about evenly spread, at corners of the hull where there are some.
  std::vector<double> places() const {
    std::vector<double> out;
    for (const Vec3& corner : corners_) out.push_back(corner.z);
    for (int i = 0; i <= kPlaces; ++i) out.push_back(from_ + (to_ - from_) * i / kPlaces);
    std::sort(out.begin(), out.end());
    const double near = std::max((to_ - from_) / (2 * kPlaces), kNear);
    const double last = std::max(to_, from_ + kNear);
    out.erase(std::unique(out.begin(), out.end(), [&](double a, double b) { return b - a < near; }),
              out.end());
    while (out.size() > 1 && last - out.back() < near) out.pop_back();
    out.push_back(last);
    return out;
  }

 private:
  const Hull& hull_;
  std::vector<Vec3> corners_;
  double from_ = 0, to_ = 0;
};

bool is_circle(const Extents& extents, double tolerance) {
  const auto [least, most] = std::minmax_element(extents.begin(), extents.end());
  return *most - *least < tolerance;
}

/// The centre of a section (Steiner point): of a circle its middle.
Vec3 center_of(const Extents& extents) {
  Vec3 out;
  for (std::size_t k = 0; k < kTangents; ++k) {
    const double angle = kStep * static_cast<double>(k);
    out = out + (2.0 / kTangents) * extents[k] * Vec3{std::cos(angle), std::sin(angle), 0};
  }
  return out;
}

/// The direction of the normal of the longest edge of a section.
double flattest(std::vector<Vec3> points) {
  const Vec3 middle = [&] {
    Vec3 sum;
    for (const Vec3& p : points) sum = sum + p;
    return (1.0 / static_cast<double>(points.size())) * sum;
  }();
  const auto angle = [&](const Vec3& p) { return std::atan2(p.y - middle.y, p.x - middle.x); };
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
  double longest = -1, out = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 edge = points[(i + 1) % points.size()] - points[i];
    if (std::hypot(edge.x, edge.y) <= longest) continue;
    longest = std::hypot(edge.x, edge.y);
    out = std::atan2(-edge.x, edge.y);
  }
  return out;
}

/// The frame of a loft along `axis`: through the centre of the middle section, x across its longest edge.
Pose frame_for(const Hull& hull, const Vec3& axis, double tolerance) {
  Pose frame = shapes::frame_along(hull.corners.front(), axis);
  const Slices first(hull, frame);
  const double middle = (first.from() + first.to()) / 2;
  const Extents extents = first.extents(middle);
  Vec3 center = center_of(extents);
  center.z = middle;
  const double turn = [&] {
    Extents around = extents;
    for (std::size_t k = 0; k < kTangents; ++k)
      around[k] -= center.x * std::cos(kStep * static_cast<double>(k)) +
                   center.y * std::sin(kStep * static_cast<double>(k));
    return is_circle(around, tolerance) ? 0.0 : flattest(first.cut(middle));
  }();
  return frame * Pose{center, from_axis_angle({0, 0, 1}, turn)};
}

struct Candidate {
  MeasuredLoft loft;
  std::size_t numbers = 0;
};

/// The largest difference between a section and the straight line between its neighbours.
double difference(const Extents& below, const Extents& above, double share, const Extents& at) {
  double out = 0;
  for (std::size_t k = 0; k < kTangents; ++k)
    out = std::max(out, std::abs(below[k] + share * (above[k] - below[k]) - at[k]));
  return out;
}

/// Adds sections where the loft is farthest from the hull, until it is within the tolerance.
Candidate fit_along(const Hull& hull, const Vec3& axis, double tolerance) {
  Candidate out;
  out.loft.frame = frame_for(hull, axis, tolerance);
  const Slices slices(hull, out.loft.frame);
  const std::vector<double> places = slices.places();
  std::vector<Extents> extents;
  for (const double place : places) extents.push_back(slices.extents(place));
  std::vector<std::size_t> used{0, places.size() - 1};
  while (used.size() < kMostSections) {
    double worst = tolerance;
    std::size_t where = 0;
    for (std::size_t u = 0; u + 1 < used.size(); ++u)
      for (std::size_t i = used[u] + 1; i < used[u + 1]; ++i) {
        const double share = (places[i] - places[used[u]]) / (places[used[u + 1]] - places[used[u]]);
        const double far = difference(extents[used[u]], extents[used[u + 1]], share, extents[i]);
        if (far <= worst) continue;
        worst = far;
        where = i;
      }
    if (where == 0) break;
    used.insert(std::upper_bound(used.begin(), used.end(), where), where);
  }
  for (const std::size_t u : used) {
    MeasuredSection section{places[u], extents[u]};
    const std::vector<double> tangents = shapes::fewest_tangents(section.extent, tolerance);
    section.extent = shapes::outline_of(tangents);
    out.numbers += 1 + tangents.size();
    out.loft.sections.push_back(section);
  }
  if (used.size() == kMostSections) out.numbers += 1000;  // not within the tolerance
  return out;
}

/// The normals of the largest flat sides.
std::vector<Vec3> large_sides(const Hull& hull, std::size_t most) {
  std::vector<std::pair<double, Vec3>> sides;
  for (const auto& face : hull.faces) {
    const Vec3 normal =
        cross(hull.corners[face[1]] - hull.corners[face[0]], hull.corners[face[2]] - hull.corners[face[0]]);
    const double area = norm(normal);
    if (area < 1e-12) continue;
    const Vec3 unit = (1 / area) * normal;
    const auto same = std::find_if(sides.begin(), sides.end(),
                                   [&](const auto& side) { return dot(side.second, unit) > 0.9999; });
    if (same != sides.end())
      same->first += area;
    else
      sides.push_back({area, unit});
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < std::min(most, sides.size()); ++i) out.push_back(sides[i].second);
  return out;
}

}  // namespace

MeasuredLoft fit_loft(const Hull& hull, double tolerance) {
  std::vector<Vec3> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3& axis : hulls::principal_axes(hull.corners).direction) axes.push_back(axis);
  for (const Vec3& axis : large_sides(hull, 4)) axes.push_back(axis);
  Candidate best;
  for (const Vec3& axis : axes) {
    Candidate one = fit_along(hull, axis, tolerance);
    if (best.numbers == 0 || one.numbers < best.numbers) best = std::move(one);
  }
  return std::move(best.loft);
}

}  // namespace polyarm::fitting
