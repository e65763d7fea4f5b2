#include "polyarm/hulls/best_cut.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace polyarm::hulls {

namespace {

constexpr std::size_t kTriangles = 300;  // sample size for comparing cuts
constexpr double kLeastGain = 0.02;      // fraction of its volume that a cut must save
constexpr std::array kOffsets = {0.25, 0.5, 0.75};
constexpr double kNever = std::numeric_limits<double>::infinity();

/// A reduced copy of a mesh, for comparing cuts.
struct Sample {
  std::vector<Triangle> triangles;
  std::vector<Vec3> points;  ///< the outermost ones

  std::vector<Vec3> corners() const {
    std::vector<Vec3> out = points;
    for (const Triangle& triangle : triangles) out.insert(out.end(), triangle.begin(), triangle.end());
    return out;
  }
};

struct Sides {
  Sample below, above;
};

Sides cut(const Sample& sample, const Plane& plane) {
  Halves halves = cut(sample.triangles, plane);
  Sides out{{std::move(halves.below), {}}, {std::move(halves.above), {}}};
  for (const Vec3& point : sample.points)
    (dot(plane.normal, point) < plane.offset ? out.below : out.above).points.push_back(point);
  return out;
}

double volume_of(const Sample& sample) {
  const std::vector<Vec3> corners = sample.corners();
  return corners.empty() ? 0 : convex_hull(corners).volume;
}

double volume_of(const Sides& sides) {
  return volume_of(sides.below) + volume_of(sides.above);
}

/// One direction in which a mesh may be cut, and the mesh's extent in it, m.
struct Way {
  Vec3 direction;
  double from = 0, to = 0;
  Plane at(double part) const { return {direction, from + part * (to - from)}; }
};

std::vector<Way> ways_across(const std::vector<Vec3>& corners, double least) {
  const Axes axes = principal_axes(corners);
  std::vector<Vec3> directions(axes.direction.begin(), axes.direction.end());
  directions.insert(directions.end(), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  std::vector<Way> out;
  for (const Vec3& direction : directions) {
    Way way{direction, kNever, -kNever};
    for (const Vec3& corner : corners) {
      way.from = std::min(way.from, dot(direction, corner));
      way.to = std::max(way.to, dot(direction, corner));
    }
    if (way.to - way.from >= 2 * least) out.push_back(way);
  }
  return out;
}

/// The smallest volume that one cut through the middle can leave.
double volume_cut_once(const Sample& sample, double least) {
  double out = volume_of(sample);
  for (const Way& way : ways_across(sample.corners(), least))
    out = std::min(out, volume_of(cut(sample, way.at(0.5))));
  return out;
}

struct Choice {
  const Way* way = nullptr;
  double part = 0, volume = kNever;
};

Choice coarse_choice(const Sample& sample, const std::vector<Way>& ways) {
  Choice out;
  for (const Way& way : ways)
    for (const double part : kOffsets)
      if (const double volume = volume_of(cut(sample, way.at(part))); volume < out.volume)
        out = {&way, part, volume};
  return out;
}

void refine(Choice& choice, const Sample& sample, double least) {
  const double width = choice.way->to - choice.way->from;
  for (double step = 0.125; step > 0.02; step /= 2)
    for (const double side : {-1.0, 1.0}) {
      const double part = choice.part + side * step;
      if (part * width < least || (1 - part) * width < least) continue;
      const double volume = volume_of(cut(sample, choice.way->at(part)));
      if (!(volume < choice.volume)) continue;
      choice.part = part;
      choice.volume = volume;
      break;
    }
}

/// The cut through the middle after which one more cut of each half leaves the smallest volume.
Choice choice_before_another(const Sample& sample, const std::vector<Way>& ways, double least) {
  Choice out;
  for (const Way& way : ways) {
    const Sides sides = cut(sample, way.at(0.5));
    if (sides.below.triangles.empty() || sides.above.triangles.empty()) continue;
    const double volume = volume_cut_once(sides.below, least) + volume_cut_once(sides.above, least);
    if (volume < out.volume) out = {&way, 0.5, volume};
  }
  return out;
}

/// Adds a triangle to its side; cuts it if the plane crosses it.
void cut(const Triangle& triangle, const Plane& plane, Halves& out) {
  std::array<double, 3> height{};
  for (std::size_t k = 0; k < 3; ++k) height[k] = dot(plane.normal, triangle[k]) - plane.offset;
  if (height[0] <= 0 && height[1] <= 0 && height[2] <= 0) return out.below.push_back(triangle);
  if (height[0] >= 0 && height[1] >= 0 && height[2] >= 0) return out.above.push_back(triangle);
  std::array<Vec3, 4> below{}, above{};
  std::size_t belows = 0, aboves = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (height[k] <= 0) below[belows++] = triangle[k];
    if (height[k] >= 0) above[aboves++] = triangle[k];
    if ((height[k] < 0) == (height[next] < 0) || height[k] == 0 || height[next] == 0) continue;
    const Vec3 at = triangle[k] + height[k] / (height[k] - height[next]) * (triangle[next] - triangle[k]);
    below[belows++] = at;
    above[aboves++] = at;
  }
  for (std::size_t k = 2; k < belows; ++k) out.below.push_back({below[0], below[k - 1], below[k]});
  for (std::size_t k = 2; k < aboves; ++k) out.above.push_back({above[0], above[k - 1], above[k]});
}

}  // namespace

Halves cut(const std::vector<Triangle>& triangles, const Plane& plane) {
  Halves out;
  for (const Triangle& triangle : triangles) cut(triangle, plane, out);
  return out;
}

BestCut best_cut(const std::vector<Triangle>& triangles, const Hull& hull, double least) {
  Sample sample{{}, hull.corners};
  const std::size_t step = triangles.size() / kTriangles + 1;
  for (std::size_t i = 0; i < triangles.size(); i += step) sample.triangles.push_back(triangles[i]);
  const std::vector<Way> ways = ways_across(hull.corners, least);
  if (ways.empty()) return {};
  const double enough = volume_of(sample) * (1 - kLeastGain);
  Choice choice = coarse_choice(sample, ways);
  if (choice.way) refine(choice, sample, least);
  if (!(choice.volume < enough)) {
    choice = choice_before_another(sample, ways, least);
    if (!(choice.volume < enough)) return {};
    return {choice.way->at(choice.part), false};
  }
  return {choice.way->at(choice.part), true};
}

}  // namespace polyarm::hulls
