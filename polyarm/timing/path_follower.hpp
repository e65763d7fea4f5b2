#pragma once
/// A planned path that is being followed: the path with its time, the limits of its joints, and the place on
/// it that each control cycle moves.
#include <span>
#include <vector>

#include "polyarm/timing/path_override.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Made outside the cycle, handed to the control thread, and freed outside the cycle. Stays where it was
/// made: what runs along the path refers to it.
class PathFollower {
 public:
  /// `limits`: of every joint, those that the path was timed with, or higher; `period_s`: of the control
  /// cycle, s. Begins held at the path's start. Throws Error "wrong-size", "bad-limit", "empty-path".
  PathFollower(TimedPath path, std::vector<trajectory::MotionLimits> limits, double period_s);
  PathFollower(const PathFollower&) = delete;
  PathFollower& operator=(const PathFollower&) = delete;

  const TimedPath& path() const noexcept { return path_; }
  std::span<const trajectory::MotionLimits> limits() const noexcept { return limits_; }
  std::size_t joints() const noexcept { return path_.joints(); }
  double period() const noexcept { return period_; }

  /// Before the first cycle: at the start, with this factor at once where the path begins at rest.
  void begin(double target) noexcept;
  /// One control cycle on the way to `target` in [-1, 1]: 1 as planned, 0 held, below zero back. No joint
  /// exceeds its limits. `immediate`: to a standstill as fast as kHarder times the acceleration (and its
  /// square times the jerk) allow, on the path as well; once begun, that goes on until it stands.
  void advance(double target, bool immediate = false) noexcept {
    stepping_back_ = false;
    override_.advance(target, immediate);
  }
  /// Begins to step back from where it is: by `time` s of the plan or by `way` along the path (in its
  /// parameter), the shorter of both, and no further than to the start. For when it stands.
  void step_back(double time, double way) noexcept;
  /// One control cycle of that, at `share` of the planned speed.
  void advance_back(double share) noexcept;
  /// What the joints do now; joints() values each.
  void sample(std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration) noexcept {
    override_.sample(position, velocity, acceleration);
  }

  /// Where on the planned time, s, and how fast it passes.
  double time() const noexcept { return override_.time(); }
  double factor() const noexcept { return override_.factor(); }
  /// The end of the path is reached.
  bool finished() const noexcept { return override_.finished(); }
  /// It rests, and has no step back to do.
  bool stands() const noexcept { return override_.stands() && !stepping_back_; }
  /// If the target became 0 now.
  StoppingWay stopping() noexcept { return override_.stopping(); }

 private:
  TimedPath path_;
  std::vector<trajectory::MotionLimits> limits_;
  double period_;
  PathOverride override_;
  bool stepping_back_ = false;
  double back_to_ = 0;
};

}  // namespace polyarm::timing
