#pragma once
/// Keeps a stream of joint targets within limits that a controller judges. Degrees and seconds. One thread;
/// begin() and next() allocate nothing.
#include <array>
#include <cstdint>

#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::wire {

using Six = std::array<double, 6>;
using Seven = std::array<double, 7>;

enum class LimitKind : std::uint32_t { velocity, acceleration, jerk };  ///< degrees and seconds

/// Velocity, acceleration and jerk of N axes.
template <std::size_t N>
struct AxisLimitsOf {
  std::array<std::array<double, N>, 3> of{};  ///< by LimitKind
  double at(LimitKind kind, std::size_t axis) const noexcept {
    return of[static_cast<std::size_t>(kind)][axis];
  }
};
using AxisLimits = AxisLimitsOf<6>;

/// The way of a stop that begins `delay` s later, by limits of acceleration and jerk.
inline double stopping_way(double velocity, double acceleration, double jerk, double delay) noexcept {
  const double v = velocity < 0 ? -velocity : velocity;
  return v * (v / acceleration + acceleration / jerk) / 2 + v * delay;
}

/// The controller judges differences between commands: velocity, acceleration and jerk are the first, second
/// and third difference by the period. A target within the limits is passed on unchanged. For another one the
/// shaper goes towards the target as fast as the limits allow, and catches up as soon as it can.
/// N is 6 or 7.
template <std::size_t N>
class ShaperOf {
 public:
  using Axes = std::array<double, N>;
  using Limits = AxisLimitsOf<N>;
  /// `period`: s, of the controller.
  explicit ShaperOf(double period = 0.008) noexcept : period_(period) {}

  /// At rest.
  void begin(const Axes& at) noexcept;
  /// The next command towards `wanted`.
  Axes next(const Axes& wanted, const Limits& limits) noexcept;
  /// The next command of the fastest stop.
  Axes brake(const Limits& limits) noexcept;

  const Axes& at() const noexcept { return at_; }
  bool still() const noexcept;
  /// Velocity after the last command, degrees/s.
  const Axes& velocity() const noexcept { return velocity_; }
  /// The largest difference between the last target and the last command, and its axis.
  double behind() const noexcept { return behind_; }
  std::size_t axis_behind() const noexcept { return axis_behind_; }
  /// Commands that were not the target.
  std::uint64_t shaped() const noexcept { return shaped_; }
  /// The limit that the last target of `axis` would have exceeded.
  LimitKind exceeded(std::size_t axis) const noexcept { return exceeded_[axis]; }

 private:
  bool allows(std::size_t axis, double target, const Limits& limits) noexcept;
  struct Moving {
    double position = 0, velocity = 0, acceleration = 0;
    bool brake = false;  ///< to a standstill, wherever that is
  };
  double steer(std::size_t axis, const Moving& moving, const Limits& limits) noexcept;
  Moving motion_of(std::size_t axis, double wanted, const Limits& limits) const noexcept;
  void advance(std::size_t axis, double position) noexcept;

  double period_;
  Axes at_{}, velocity_{}, acceleration_{}, wanted_{}, desired_velocity_{};
  double behind_ = 0;
  std::size_t axis_behind_ = 0;
  std::uint64_t shaped_ = 0;
  std::array<LimitKind, N> exceeded_{};
  trajectory::StateToState planner_;
};
using Shaper = ShaperOf<6>;

}  // namespace polyarm::wire
