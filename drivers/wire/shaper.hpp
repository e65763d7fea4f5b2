#pragma once
/// Keeps a stream of joint targets within limits that a controller judges. Degrees and seconds. One thread;
/// begin() and next() allocate nothing.
#include <array>
#include <cstdint>

#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::wire {

using Six = std::array<double, 6>;

enum class LimitKind : std::uint32_t { velocity, acceleration, jerk };  ///< degrees and seconds

/// Velocity, acceleration and jerk of six axes.
struct AxisLimits {
  std::array<Six, 3> of{};  ///< by LimitKind
  double at(LimitKind kind, std::size_t axis) const noexcept {
    return of[static_cast<std::size_t>(kind)][axis];
  }
};

/// The controller judges differences between commands: velocity, acceleration and jerk are the first, second
/// and third difference by the period. A target within the limits is passed on unchanged. For another one the
/// shaper goes towards the target as fast as the limits allow, and catches up as soon as it can.
class Shaper {
 public:
  /// `period`: s, of the controller.
  explicit Shaper(double period = 0.008) noexcept : period_(period) {}

  /// At rest.
  void begin(const Six& at) noexcept;
  /// The next command towards `wanted`.
  Six next(const Six& wanted, const AxisLimits& limits) noexcept;
  /// The next command of the fastest stop.
  Six brake(const AxisLimits& limits) noexcept;

  const Six& at() const noexcept { return at_; }
  bool still() const noexcept;
  /// Velocity after the last command, degrees/s.
  const Six& velocity() const noexcept { return velocity_; }
  /// The largest difference between the last target and the last command, and its axis.
  double behind() const noexcept { return behind_; }
  std::size_t axis_behind() const noexcept { return axis_behind_; }
  /// Commands that were not the target.
  std::uint64_t shaped() const noexcept { return shaped_; }
  /// The limit that the last target of `axis` would have exceeded.
  LimitKind exceeded(std::size_t axis) const noexcept { return exceeded_[axis]; }

 private:
  bool allows(std::size_t axis, double target, const AxisLimits& limits) noexcept;
  struct Moving {
    double position = 0, velocity = 0, acceleration = 0;
    bool brake = false;  ///< to a standstill, wherever that is
  };
  double steer(std::size_t axis, const Moving& moving, const AxisLimits& limits) noexcept;
  Moving motion_of(std::size_t axis, double wanted, const AxisLimits& limits) const noexcept;
  void advance(std::size_t axis, double position) noexcept;

  double period_;
  Six at_{}, velocity_{}, acceleration_{}, wanted_{}, desired_velocity_{};
  double behind_ = 0;
  std::size_t axis_behind_ = 0;
  std::uint64_t shaped_ = 0;
  std::array<LimitKind, 6> exceeded_{};
  trajectory::StateToState planner_;
};

}  // namespace polyarm::wire
