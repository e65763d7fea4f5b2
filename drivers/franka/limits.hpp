#pragma once
/// Limits at which a robot of Franka stops: velocity, acceleration and jerk of commanded joints, as the maker
/// documents them ("Robot and interface specifications", "Limits for Panda" and "for Franka Research 3").
/// rad and seconds. Const: any thread; real-time.
#include "drivers/wire/shaper.hpp"

namespace polyarm::franka {

using wire::Seven;

struct MotionLimits {
  Seven velocity{};  ///< far away from the ends of the range
  Seven acceleration{}, jerk{};
  bool by_position = false;  ///< the velocity is lower near the ends of the range (Franka Research 3)
};
/// `version`: of the Franka Control Interface; 5 is a Panda.
const MotionLimits& motion_limits(int version) noexcept;

/// Bounds of the velocity of joint `joint` at position `q`, rad and rad/s. `lower` is not above zero.
struct VelocityBounds {
  double lower, upper;
};
VelocityBounds velocity_bounds(int version, std::size_t joint, double q) noexcept;

}  // namespace polyarm::franka
