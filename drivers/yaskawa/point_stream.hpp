#pragma once
/// Makes the points of a trajectory from a stream of joint targets. A controller of Yaskawa keeps the points
/// in a buffer and interpolates a cubic between two of them, by time, position and velocity. Degrees; the
/// times are whole milliseconds, as the controller cuts them. One thread.
#include <cstdint>
#include <deque>

#include "drivers/wire/shaper.hpp"

namespace polyarm::yaskawa {

using wire::Six;

struct TimedPoint {
  int sequence = 0;
  int time_ms = 0;
  Six position{}, velocity{};  ///< degrees, degrees/s
};

/// The velocity of a point is the difference of its neighbours, so that each point waits for the next one.
/// The first two points of a trajectory hold the robot for `lead` ms: that is what the controller's buffer
/// then holds ahead.
class PointStream {
 public:
  /// `cycles`: of the loop, for one point.
  PointStream(int period_ms, int lead_ms, int cycles)
      : period_(period_ms), lead_(lead_ms), cycles_(cycles), shaper_(period_ms / 1000.0 / cycles) {}

  /// The robot stands at `at`; no trajectory is open.
  void begin(const Six& at);
  /// The target of the next cycle of the loop.
  void go(const Six& target, const wire::AxisLimits& limits);
  /// A cycle of the fastest stop.
  void brake(const wire::AxisLimits& limits);
  /// The next target opens a new trajectory. Only at rest.
  void rest();

  /// Points to send.
  std::deque<TimedPoint>& out() { return out_; }
  bool open() const { return open_; }
  /// The last points have no velocity.
  bool stands() const { return !open_ || still_ >= kStandsAfter; }
  /// ms of the trajectory.
  int time_ms() const { return time_; }
  /// ms that it has stood.
  int still_ms() const { return still_ * period_; }
  /// The next intervals are so many ms longer, -1 to 1: the controller's clock is not this computer's.
  void trim(int ms) { trim_ = ms; }
  const wire::Shaper& shaper() const { return shaper_; }

 private:
  static constexpr int kStandsAfter = 3;  // points at the same place
  void open_at_rest();
  void take(const Six& position);
  void push(const Six& position);
  int period_, lead_, cycles_, trim_ = 0;
  wire::Shaper shaper_;
  bool open_ = false, pending_ = false;
  int time_ = 0, sequence_ = 0, still_ = 0;
  int since_ = 0;  ///< cycles since the last point
  int before_time_ = 0;
  Six before_{}, last_{};  ///< the point before the pending one; the pending one
  std::deque<TimedPoint> out_;
};

}  // namespace polyarm::yaskawa
