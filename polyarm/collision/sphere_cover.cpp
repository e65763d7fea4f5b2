#include "polyarm/collision/sphere_cover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/collision/separation.hpp"
#include "polyarm/hulls/hull.hpp"

namespace polyarm::collision {

namespace {

constexpr double kGrown = 1e-7;  // m: more than what rounding and kFlat take away
constexpr double kFlat = 1e-12;  // m: a corner nearer to the line of its neighbours is left out

/// Bodies, or parts of them, and the sphere around them.
struct Cluster {
  std::vector<ConvexBody> parts;
  Ball ball;
  double excess = 0;
};

double distance_to(const std::vector<ConvexBody>& bodies, const Vec3& point, double enough) {
  const ConvexBody dot_body{{point}, 0, 0, {0, 0, 1}};
  double least = INFINITY;
  for (const ConvexBody& body : bodies) {
    least = std::min(least, separation(dot_body, {}, body).distance);
    if (least <= enough) break;
  }
  return least;
}

double excess_of(const std::vector<ConvexBody>& bodies, const Ball& ball) {
  constexpr int kDirections = 40;
  double out = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3 direction{r * std::cos(angle), r * std::sin(angle), z};
    out = std::max(out, distance_to(bodies, ball.center + ball.radius * direction, out));
  }
  return out;
}

Cluster cluster_of(const std::vector<ConvexBody>& all, std::vector<ConvexBody> parts) {
  Cluster out;
  out.ball = bounding_ball(parts);
  out.ball.radius += kGrown;
  out.parts = std::move(parts);
  out.excess = excess_of(all, out.ball);
  return out;
}

/// The corners of the planar hull of points in a plane with the given normal (Andrew's monotone chain).
std::vector<Vec3> planar_hull(std::vector<Vec3> points, const Vec3& normal) {
  if (points.size() < 4) return points;
  const Vec3 u = normalized(cross(normal, std::abs(normal.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(normal, u);
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
    const double ax = dot(a, u), bx = dot(b, u);
    return ax < bx || (ax == bx && dot(a, v) < dot(b, v));
  });
  const auto left = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return dot(cross(b - a, c - a), normal) > kFlat * norm(c - a);
  };
  std::vector<Vec3> out;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = out.size();
    for (const Vec3& p : points) {
      while (out.size() >= begin + 2 && !left(out[out.size() - 2], out.back(), p)) out.pop_back();
      out.push_back(p);
    }
    out.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return out.empty() ? std::vector<Vec3>{points.front()} : out;
}

/// Adds the parts of `body` on both sides of the plane.
void cut(const ConvexBody& body, const Vec3& normal, double offset, std::vector<ConvexBody>& below,
         std::vector<ConvexBody>& above) {
  ConvexBody low, high;
  low.radius = high.radius = body.radius;
  for (const Vec3& p : body.points) (dot(normal, p) < offset ? low : high).points.push_back(p);
  if (!low.points.empty() && !high.points.empty()) {
    std::vector<Vec3> between;
    for (const Vec3& a : low.points)
      for (const Vec3& b : high.points) {
        const double from = dot(normal, a) - offset, to = dot(normal, b) - offset;
        between.push_back(a + (from / (from - to)) * (b - a));
      }
    between = planar_hull(std::move(between), normal);
    low.points.insert(low.points.end(), between.begin(), between.end());
    high.points.insert(high.points.end(), between.begin(), between.end());
  }
  if (!low.points.empty()) below.push_back(std::move(low));
  if (!high.points.empty()) above.push_back(std::move(high));
}

/// Cuts the cluster in the middle of its longest extent. False if it has none.
bool halve(const std::vector<ConvexBody>& all, const Cluster& cluster, Cluster& first, Cluster& second) {
  std::vector<Vec3> points;
  for (const ConvexBody& part : cluster.parts)
    points.insert(points.end(), part.points.begin(), part.points.end());
  const hulls::Axes axes = hulls::principal_axes(points);
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (axes.upper[i] - axes.lower[i] > axes.upper[longest] - axes.lower[longest]) longest = i;
  const Vec3& normal = axes.direction[longest];
  double lower = INFINITY, upper = -INFINITY;
  for (const Vec3& p : points)
    lower = std::min(lower, dot(normal, p)), upper = std::max(upper, dot(normal, p));
  if (!(upper - lower > 1e-4)) return false;
  std::vector<ConvexBody> below, above;
  for (const ConvexBody& part : cluster.parts) cut(part, normal, (lower + upper) / 2, below, above);
  if (below.empty() || above.empty()) return false;
  first = cluster_of(all, std::move(below));
  second = cluster_of(all, std::move(above));
  return true;
}

bool is_capsule(const ConvexBody& body) {
  return body.points.size() <= 2 && body.disc <= 0 && body.radius > 0;
}

/// Spheres in a row on the segment of a capsule, from end to end: a sphere at distance h from the next
/// reaches the rim between both with the radius root(r² + (h / 2)²).
void cover_capsule(const ConvexBody& capsule, const CoverOptions& options, SphereCover& out) {
  const Vec3 from = capsule.points.front(), way = capsule.points.back() - from;
  const double length = norm(way), r = capsule.radius, wanted = r + options.desired_excess;
  const double widest = 2 * std::sqrt(wanted * wanted - r * r);
  const double gaps = std::clamp(std::ceil(length / std::max(widest, 1e-6)), 0.0,
                                 double(std::max<std::size_t>(options.most_spheres, 1)) - 1);
  if (gaps == 0) {
    out.spheres.push_back({from + 0.5 * way, r + length / 2 + kGrown});
    out.largest_excess = std::max(out.largest_excess, length / 2);
    return;
  }
  const double half = length / gaps / 2, radius = std::hypot(r, half) + kGrown;
  for (double i = 0; i <= gaps; ++i) out.spheres.push_back({from + (i / gaps) * way, radius});
  out.largest_excess = std::max(out.largest_excess, radius - r);
}

void cover_rest(const std::vector<ConvexBody>& bodies, const std::vector<ConvexBody>& rest,
                const CoverOptions& options, SphereCover& out) {
  std::vector<Cluster> clusters{cluster_of(bodies, rest)};
  while (clusters.size() + out.spheres.size() < options.most_spheres) {
    const auto worst = std::max_element(clusters.begin(), clusters.end(),
                                        [](const auto& a, const auto& b) { return a.excess < b.excess; });
    if (worst->excess <= options.desired_excess) break;
    Cluster first, second;
    if (halve(bodies, *worst, first, second)) {
      *worst = std::move(first);
      clusters.push_back(std::move(second));
    } else {
      out.largest_excess = std::max(out.largest_excess, worst->excess);
      worst->excess = 0;  // cannot be cut
    }
  }
  for (const Cluster& cluster : clusters) {
    out.spheres.push_back(cluster.ball);
    out.largest_excess = std::max(out.largest_excess, cluster.excess);
  }
}

}  // namespace

SphereCover cover(const std::vector<ConvexBody>& bodies, const CoverOptions& options) {
  SphereCover out;
  std::vector<ConvexBody> rest;
  std::size_t capsules = 0;
  for (const ConvexBody& body : bodies)
    if (is_capsule(body))
      ++capsules;
    else
      rest.push_back(without_discs(body));
  CoverOptions of_one = options;
  if (capsules > 0) of_one.most_spheres = options.most_spheres / (capsules + (rest.empty() ? 0 : 1));
  for (const ConvexBody& body : bodies)
    if (is_capsule(body)) cover_capsule(body, of_one, out);
  if (!rest.empty()) cover_rest(bodies, rest, options, out);
  return out;
}

}  // namespace polyarm::collision
