#pragma once
/// Time-optimal motion of several axes from any state to any state, with limited velocity, acceleration and
/// jerk. Each axis has its own unit (rad, m, mm …); times in seconds. For the control cycle: no allocation,
/// no exceptions, no clock, bounded time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "polyarm/trajectory/constant_jerk.hpp"

namespace polyarm::trajectory {

struct MotionState {
  double position = 0, velocity = 0, acceleration = 0;
};

/// The lower limits of velocity and acceleration are negative.
struct MotionLimits {
  double max_velocity = 1, max_acceleration = 1, max_jerk = 1;
  double min_velocity = -1, min_acceleration = -1;
  static MotionLimits symmetric(double velocity, double acceleration, double jerk) noexcept {
    return {velocity, acceleration, jerk, -velocity, -acceleration};
  }
};

/// none: each axis moves as fast as it can. time: all axes arrive together, as early as possible. phase: all
/// axes also move in proportion, on a straight line, if the states allow it; otherwise as time.
enum class Synchronization : std::uint8_t { none, time, phase };

/// position: the axis reaches the target's position, velocity and acceleration. velocity: it reaches the
/// target's velocity and acceleration at any position.
enum class TargetKind : std::uint8_t { position, velocity };

struct MotionOptions {
  Synchronization synchronization = Synchronization::time;
  TargetKind target = TargetKind::position;
  double minimum_duration = 0;  ///< s
};

enum class MotionStatus : std::uint8_t {
  ok,
  wrong_size,      ///< spans are empty, differ in size, or have more than kMostAxes values
  bad_number,      ///< a number is not finite
  bad_limit,       ///< a limit has the wrong sign
  target_outside,  ///< no motion within limits reaches the target's velocity and acceleration
};
const char* name(MotionStatus status) noexcept;

/// The motion of one axis: pieces of constant jerk.
class AxisMotion {
 public:
  /// The pieces of the motion back inside the limits, and of two extremal motions.
  static constexpr std::size_t kMostPieces = 4 + 14;

  double duration() const noexcept { return duration_; }
  /// After the end the axis continues with the target's velocity and zero acceleration.
  MotionState at(double t) const noexcept;
  std::size_t pieces() const noexcept { return count_; }
  /// Start of piece `i`, s; the state there; its jerk.
  double begin_of(std::size_t i) const noexcept { return pieces_[i].begin; }
  const MotionState& state_of(std::size_t i) const noexcept { return pieces_[i].state; }
  double jerk_of(std::size_t i) const noexcept { return pieces_[i].jerk; }

 private:
  friend class StateToState;
  friend class AxisPlan;
  struct Piece {
    double begin;
    MotionState state;
    double jerk;
  };
  void start(const MotionState& at) noexcept {
    count_ = 0;
    duration_ = 0;
    end_ = at;
  }
  void append(double time, double jerk) noexcept {
    if (!(time > 0) || count_ == kMostPieces) return;
    pieces_[count_++] = {duration_, end_, jerk};
    const JerkState end = after({end_.position, end_.velocity, end_.acceleration}, time, jerk);
    end_ = {end.p, end.v, end.a};
    duration_ += time;
  }
  void finish(const MotionState& at, double duration) noexcept {
    if (count_ == 0) pieces_[count_++] = {0, end_, 0};
    end_ = at;
    duration_ = duration;
  }

  std::array<Piece, kMostPieces> pieces_;
  std::size_t count_ = 0;
  double duration_ = 0;
  MotionState end_;
};

/// Plans once, or again in every cycle for a moving target.
///
/// Method: for a given duration the reachable displacements of an axis form an interval, whose ends are
/// motions in closed form (axis_reach.hpp). The earliest arrival is when the target enters that interval. A
/// longer motion is a mixture of both ends; it keeps every limit because limits are convex. Between two rests
/// it is the fastest motion of its duration, scaled. Some durations are impossible for an axis, because it
/// would have to turn back on the way; these are found when other axes require them.
///
/// Start outside the limits: the axis first returns inside, then moves as fast as the limits allow. Inside
/// means that it can stay inside: acceleration and velocity are within their limits, and so is the velocity
/// after full jerk has brought the acceleration to zero. The return is the shortest motion in which the
/// acceleration returns first, at full jerk, and then stays within its limits. The velocity does not pass the
/// opposite limit, unless the acceleration at the start is too large for that.
class StateToState {
 public:
  static constexpr std::size_t kMostAxes = 128;

  /// After any status but ok the last motion is unchanged.
  MotionStatus plan(std::span<const MotionState> start, std::span<const MotionState> target,
                    std::span<const MotionLimits> limits, const MotionOptions& options = {}) noexcept;

  std::size_t axes() const noexcept { return count_; }
  /// The arrival time of the last axis, s.
  double duration() const noexcept { return duration_; }
  const AxisMotion& axis(std::size_t i) const noexcept { return motions_[i]; }
  /// All axes, `t` seconds after the start. `out`: axes() states.
  void sample(double t, std::span<MotionState> out) const noexcept;
  /// True if the motion is a straight line. Only valid after a plan with Synchronization::phase.
  bool straight() const noexcept { return straight_; }

 private:
  bool plan_straight(std::span<const MotionState> start, std::span<const MotionState> target,
                     std::span<const MotionLimits> limits, const MotionOptions& options) noexcept;

  std::size_t count_ = 0;
  double duration_ = 0;
  bool straight_ = false;
  std::array<AxisMotion, kMostAxes> motions_;
};

}  // namespace polyarm::trajectory
