#include "polyarm/wheels/steering_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polyarm::controllers {

namespace {
using Kind = SteeringGeometry::Kind;
constexpr double kStraight = 1e-6;                        // rad
constexpr double kFullSpeedBelow = std::numbers::pi / 6;  // rad
constexpr double kLeastSteering = 1e-3;                   // rad: with less it only drives straight
constexpr double kSlowest = 1.5608;                       // rad: a little before the cosine is 0
}  // namespace

double sharpest_curvature(const SteeringGeometry& geometry, double limit) noexcept {
  // The inner joint of an Ackermann axle turns farthest.
  const double inner = geometry.kind == Kind::ackermann ? geometry.steering_track / 2 : 0;
  return 1 / (geometry.wheelbase / std::tan(std::clamp(limit, kLeastSteering, kMostSteering)) + inner);
}

double steering_angle(const SteeringGeometry& geometry, double v, double w) noexcept {
  const double angle = std::atan(w * geometry.wheelbase / v);
  return std::isfinite(angle) ? angle : 0;
}

RightLeft steering_joints(const SteeringGeometry& geometry, double middle) noexcept {
  if (geometry.kind != Kind::ackermann || std::abs(middle) < kStraight) return {middle, middle};
  const double across = 2 * geometry.wheelbase * std::sin(middle);
  const double along = 2 * geometry.wheelbase * std::cos(middle);
  const double aside = geometry.steering_track * std::sin(middle);
  return {std::atan2(across, along + aside), std::atan2(across, along - aside)};
}

double middle_angle(const SteeringGeometry& geometry, const RightLeft& joints) noexcept {
  if (geometry.kind != Kind::ackermann) return joints[0];
  const double half = geometry.steering_track / 2, length = geometry.wheelbase;
  const auto middle = [&](double angle, double offset) {
    const double slope = std::tan(angle);
    return std::atan(length * slope / (length + offset * slope));
  };
  return (middle(joints[0], -half) + middle(joints[1], half)) / 2;
}

RightLeft traction_wheels(const SteeringGeometry& geometry, double wheel, double middle) noexcept {
  if (geometry.kind == Kind::bicycle || std::abs(middle) < kStraight) return {wheel, wheel};
  // The ratio of half the track to the radius of the turn: larger on the outside.
  const double ratio = geometry.traction_track / 2 * std::tan(middle) / geometry.wheelbase;
  return {wheel * (1 + ratio), wheel * (1 - ratio)};
}

double traction_speed(const SteeringGeometry& geometry, const RightLeft& wheels, double middle) noexcept {
  if (geometry.kind == Kind::bicycle) return wheels[0] * geometry.radius;
  const double ratio = geometry.traction_track / 2 * std::tan(middle) / geometry.wheelbase;
  return (wheels[0] / (1 + ratio) + wheels[1] / (1 - ratio)) / 2 * geometry.radius;
}

double share_while_steering(double error) noexcept {
  const double off = std::abs(error);
  return off < kFullSpeedBelow ? 1 : std::cos(std::min(off, kSlowest)) / std::cos(kFullSpeedBelow);
}

}  // namespace polyarm::controllers
