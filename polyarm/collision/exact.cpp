#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polyarm/collision/check_data.hpp"
#include "polyarm/collision/checker.hpp"
#include "polyarm/collision/separation.hpp"

namespace polyarm::collision {

namespace {

constexpr double kBoundRounding = 1e-9;  // m

using Poses = std::array<Pose, kMostSteps>;

Pose pose_of(const Poses& poses, const LinkBody& link) {
  return link.frame < 0 ? Pose{} : poses[static_cast<std::size_t>(link.frame)];
}

/// Two bodies and their distance. Half-spaces have no body.
struct Meeting {
  Separation between;
  Vec3 normal;  // half-space: out of it
};

Separation from_half_space(const ConvexBody& body, const Pose& pose, const HalfSpace& space) {
  const Vec3 local = inverse(pose.rotation) * space.normal;
  const Vec3 deepest = pose * body.core_support(-local) - body.radius * space.normal;
  const double distance = dot(space.normal, deepest) - space.offset;
  return {distance, distance, deepest, deepest - distance * space.normal};
}

Separation apart(const ConvexBody& body, const Pose& pose, const Obstacle& obstacle) {
  return obstacle.is_half_space ? from_half_space(body, pose, obstacle.half_space)
                                : separation(body, pose, obstacle.body);
}

/// A lower bound of the distance of anything in `ball` from the obstacle.
double bound(const Ball& ball, const Pose& pose, const Obstacle& obstacle) {
  if (!obstacle.is_half_space && obstacle.kind == description::ShapeKind::box) {
    const Vec3 local = inverse(obstacle.pose) * (pose * ball.center);
    const Vec3 beyond{std::max(std::abs(local.x) - obstacle.half.x, 0.0),
                      std::max(std::abs(local.y) - obstacle.half.y, 0.0),
                      std::max(std::abs(local.z) - obstacle.half.z, 0.0)};
    return norm(beyond) - ball.radius - kBoundRounding;
  }
  return apart({{ball.center}, ball.radius, 0, {0, 0, 1}}, pose, obstacle).lower;
}

/// Calls take(index) for each obstacle of a link whose bound may be at most range().
template <typename Range, typename Take>
void each_near(const CheckData::Nearby& near, const Ball& ball, const Pose& pose, const Range& range,
               const Take& take) {
  for (const std::size_t i : near.always) take(i);
  near.tree.each_near(
      pose * ball.center, [&] { return range() + ball.radius + kBoundRounding; },
      [&](std::uint32_t leaf) { take(near.obstacle[leaf]); });
}

double ball_bound(const Ball& a, const Pose& pose_a, const Ball& b, const Pose& pose_b) {
  return norm(pose_a * a.center - pose_b * b.center) - a.radius - b.radius;
}

}  // namespace

/// Every pair of bodies: farther apart than its margin, nearer, or touching.
Probe::ExactVerdict Probe::exact(std::span<const double> q, std::span<const double> margins) noexcept {
  const RobotBody& robot = checker_.robot();
  const CheckData& data = checker_.data();
  Poses poses;
  robot.place(q, poses);
  ExactVerdict out = ExactVerdict::free;
  const auto margin = [&](std::size_t row) { return margins.empty() ? 0.0 : margins[row]; };
  for (std::size_t l = 0; l < data.links.size(); ++l) {
    const LinkBody& link = robot.links()[data.body_of_link[l]];
    const Pose pose = pose_of(poses, link);
    const double touch = checker_.clearance(), wanted = touch + margin(l);
    bool touches = false;
    each_near(
        data.reachable_near[l], link.around, pose, [&] { return touches ? -1e9 : wanted; },
        [&](std::size_t i) {
          const Obstacle& obstacle = checker_.obstacles()[i];
          if (touches || bound(link.around, pose, obstacle) > wanted) return;
          for (const ConvexBody& body : link.bodies) {
            const double lower = apart(body, pose, obstacle).lower;
            if (!(lower > touch)) touches = true;
            if (!(lower > wanted)) out = ExactVerdict::near;
          }
        });
    if (touches) return ExactVerdict::touches;
  }
  for (std::size_t p = 0; p < robot.pairs().size(); ++p) {
    const LinkPairBody& pair = robot.pairs()[p];
    const LinkBody &a = robot.links()[pair.first], &b = robot.links()[pair.second];
    const Pose pose_a = pose_of(poses, a), pose_b = pose_of(poses, b);
    const double wanted = margin(data.links.size() + p);
    if (ball_bound(a.around, pose_a, b.around, pose_b) > wanted) continue;
    const Pose T_b_a = inverse(pose_b) * pose_a;
    for (const ConvexBody& first : a.bodies)
      for (const ConvexBody& second : b.bodies) {
        const double lower = separation(first, T_b_a, second).lower;
        if (!(lower > 0)) return ExactVerdict::touches;
        if (!(lower > wanted)) out = ExactVerdict::near;
      }
  }
  return out;
}

bool Probe::touches_exactly(std::span<const double> q) noexcept {
  if (!checker_.usable(q)) return true;
  return exact(q, {}) == ExactVerdict::touches;
}

namespace {

/// The nearest pair so far; bodies that overlap are compared by their depth.
struct Best {
  const Checker& checker;
  const LinkBody* first = nullptr;
  const std::string* second = nullptr;
  double distance = std::numeric_limits<double>::infinity();
  Vec3 on_first, on_second;  // in the base

  void offer(const LinkBody& link, const std::string& other, const Separation& s, double depth,
             const Pose& T_base) {
    const double d = s.distance > 0 ? s.distance : -depth;
    if (d >= distance) return;
    distance = d;
    first = &link, second = &other;
    on_first = T_base * s.on_a, on_second = T_base * s.on_b;
  }
};

/// The deepest point of a body in another one, roughly: where both lie between their middles.
Separation overlapping(Separation s, const ConvexBody& a, const Pose& pose, const ConvexBody& b) {
  const Depth depth = overlap(a, pose, b);
  const Vec3 inner =
      pose * a.core_support(inverse(pose.rotation) * -depth.direction) - a.radius * depth.direction;
  s.on_a = inner;
  s.on_b = inner + depth.depth * depth.direction;
  s.lower = -depth.depth;
  return s;
}

void compare(Best& best, const LinkBody& link, const Pose& pose, const Obstacle& obstacle) {
  for (const ConvexBody& body : link.bodies) {
    Separation s = apart(body, pose, obstacle);
    double depth = -s.distance;
    if (s.distance <= 0 && !obstacle.is_half_space) {
      s = overlapping(s, body, pose, obstacle.body);
      depth = -s.lower;
    }
    best.offer(link, obstacle.name, s, depth, {});
  }
}

void compare(Best& best, const LinkBody& a, const Pose& pose_a, const LinkBody& b, const Pose& pose_b) {
  const Pose T_b_a = inverse(pose_b) * pose_a;
  for (const ConvexBody& first : a.bodies)
    for (const ConvexBody& second : b.bodies) {
      Separation s = separation(first, T_b_a, second);
      double depth = 0;
      if (s.distance <= 0) {
        s = overlapping(s, first, T_b_a, second);
        depth = -s.lower;
      }
      best.offer(a, b.name, s, depth, pose_b);
    }
}

}  // namespace

Contact Probe::nearest(std::span<const double> q) {
  const RobotBody& robot = checker_.robot();
  const CheckData& data = checker_.data();
  Contact out;
  out.distance = std::numeric_limits<double>::infinity();
  if (!checker_.usable(q)) return out;
  Poses poses;
  robot.place(q, poses);
  Best best{checker_, nullptr, nullptr, out.distance, {}, {}};
  for (std::size_t l = 0; l < data.links.size(); ++l) {
    const LinkBody& link = robot.links()[data.body_of_link[l]];
    const Pose pose = pose_of(poses, link);
    each_near(
        data.measured_near[l], link.around, pose, [&] { return best.distance; },
        [&](std::size_t i) {
          if (bound(link.around, pose, checker_.obstacles()[i]) < best.distance)
            compare(best, link, pose, checker_.obstacles()[i]);
        });
  }
  for (const LinkPairBody& pair : robot.pairs()) {
    const LinkBody &a = robot.links()[pair.first], &b = robot.links()[pair.second];
    const Pose pose_a = pose_of(poses, a), pose_b = pose_of(poses, b);
    if (ball_bound(a.around, pose_a, b.around, pose_b) < best.distance) compare(best, a, pose_a, b, pose_b);
  }
  if (!best.first) return out;
  out.first = best.first->name;
  out.second = *best.second;
  out.distance = best.distance;
  out.on_first = checker_.base() * best.on_first;
  out.on_second = checker_.base() * best.on_second;
  return out;
}

}  // namespace polyarm::collision
