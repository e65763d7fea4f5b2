#pragma once
/// Follows a planned path in the control cycle: holds the timed path, the limits of its joints, and the
/// present place on the path. Radians or metres, seconds.
#include <span>
#include <vector>

#include "polyarm/timing/path_override.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Create it outside the cycle, hand it to the control thread, and free it outside the cycle. It cannot be
/// moved, because the override refers to its path.
class PathFollower {
 public:
  /// `limits`: of every joint, at least those that the path was timed with; `period_s`: of the control cycle,
  /// s. The initial state is held at the start of the path. Throws Error "wrong-size", "bad-limit",
  /// "empty-path".
  PathFollower(TimedPath path, std::vector<trajectory::MotionLimits> limits, double period_s);
  PathFollower(const PathFollower&) = delete;
  PathFollower& operator=(const PathFollower&) = delete;

  const TimedPath& path() const noexcept { return path_; }
  std::span<const trajectory::MotionLimits> limits() const noexcept { return limits_; }
  std::size_t joints() const noexcept { return path_.joints(); }
  double period() const noexcept { return period_; }

  /// Call it before the first cycle. Sets the place to the start of the path, and the factor to `target` at
  /// once if the path begins at rest.
  void begin(double target) noexcept;
  /// Call it before begin(): the path begins at this time of the plan, s, at rest.
  void start_at(double time) noexcept;
  /// One control cycle towards the factor `target` in [-1, 1]: 1 as planned, 0 held, negative backwards. No
  /// joint exceeds its limits. `immediate`: stops as fast as kHarder times the acceleration (and its square
  /// times the jerk) allow, still on the path; once begun, the stop continues to standstill.
  void advance(double target, bool immediate = false) noexcept {
    stepping_back_ = false;
    override_.advance(target, immediate);
  }
  /// Begins a step back from the present place: by `time` s of the plan or by `way` along the path (in its
  /// parameter), whichever is shorter, at most to the start. Only at standstill.
  void step_back(double time, double way) noexcept;
  /// One control cycle of the step back, at `share` of the planned speed.
  void advance_back(double share) noexcept;
  /// The present joint state; joints() values each.
  void sample(std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration) noexcept {
    override_.sample(position, velocity, acceleration);
  }

  /// Time on the plan, s, and its rate.
  double time() const noexcept { return override_.time(); }
  double factor() const noexcept { return override_.factor(); }
  /// True if the end of the path is reached.
  bool finished() const noexcept { return override_.finished(); }
  /// True if it is at standstill and has no step back to do.
  bool stands() const noexcept { return override_.stands() && !stepping_back_; }
  /// The stop that would follow if the target became 0 now.
  StoppingWay stopping() noexcept { return override_.stopping(); }

 private:
  TimedPath path_;
  std::vector<trajectory::MotionLimits> limits_;
  double period_;
  PathOverride override_;
  bool stepping_back_ = false;
  double back_to_ = 0, start_ = 0;
};

}  // namespace polyarm::timing
