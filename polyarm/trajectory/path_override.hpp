#pragma once
/// Runs along a timed path at any speed: override, hold, resume and back, without leaving the path or a
/// limit.
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/trajectory/path_trajectory.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::trajectory {

/// Until the path stands still: seconds, and the way along the path (in its parameter; below zero: back).
struct StoppingWay {
  double time = 0, way = 0;
  bool known = true;  ///< false: no stop within the look-ahead keeps the limits
};

/// The place on a timed path as the control cycle moves it, and the factor at which its time runs: 1 as
/// planned, 0 held, below zero back. In each cycle the factor's second derivative is constant, so joints have
/// limited jerk. What the joints do is q(τ), with τ' = f:
///   q' = q̇f,  q'' = q̈f² + q̇f',  q''' = q⃛f³ + 3q̈ff' + q̇f''
/// (q̇, q̈, q⃛ as planned). A plan that keeps the limits keeps them at any constant f in [0, 1].
///
/// Method: a law drives f to its target as fast as the rows above leave room for f' and f''; how much of that
/// room it uses is its boldness. A run of the law from the present to the target, in steps of the cycle,
/// shows whether a boldness keeps every limit to the end; only such a one is followed, and the law being
/// deterministic the cycles then do what the run did. Each cycle tries a bolder one, where room is left.
///
/// Control thread. advance() allocates nothing, throws nothing, and takes at most kMostRuns runs, of
/// kMostSteps steps together (a step: a few looks at the path); a manoeuvre that needs more steps is not
/// found. Keeps references to the path and limits given.
class PathOverride {
 public:
  static constexpr std::size_t kMostSteps = 1500;
  static constexpr std::size_t kMostRuns = 2;
  /// An immediate stop takes this many times the acceleration, and its square times the jerk.
  static constexpr double kHarder = 3;

  /// Outside the cycle. `limits`: of every joint, those that the path was planned with, or higher; `period`:
  /// of the control cycle, s. Begins held at the path's start. Throws Error "wrong-size", "bad-limit".
  PathOverride(const TimedPath& path, std::span<const MotionLimits> limits, double period);

  /// From `time` on the plan, at a steady `factor`; for when the path is followed already, or nothing moves.
  void begin(double time, double factor) noexcept;
  /// One cycle on the way to `target` in [-1, 1] (clamped; not a number counts as 0). Backwards it goes no
  /// faster than the joints' slower directions allow. `immediate`: brakes to 0 with harder limits; once it
  /// does, it goes on until it stands, whatever is asked meanwhile.
  void advance(double target, bool immediate = false) noexcept;

  /// Where on the planned time, s; the factor and its derivatives by time (the second: during the last
  /// cycle).
  double time() const noexcept { return state_.time; }
  double factor() const noexcept { return state_.factor; }
  double rate() const noexcept { return state_.rate; }
  double bend() const noexcept { return bend_; }
  bool finished() const noexcept { return state_.time >= path_.duration(); }
  bool stands() const noexcept { return state_.factor == 0 && state_.rate == 0; }

  /// What the joints do now. Spans as with TimedPath::sample, jerk left out.
  void sample(std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration) noexcept;
  /// If the target became 0 now. One run at most for each boldness.
  StoppingWay stopping() noexcept;

 private:
  struct State {
    double time = 0, factor = 0, rate = 0;
  };
  /// The room that the rows leave: for f' and for f''.
  struct Room {
    double rate_low, rate_high, bend_low, bend_high;
    double faster_low, faster_high;  // f' that needs no f'' against it
  };
  struct Run {
    bool safe;
    State end;
    std::size_t steps;
  };
  Room room(const State& s) noexcept;
  bool within(const State& s, double bend) noexcept;
  double law(const State& s, const Room& room, double target, std::size_t level) const noexcept;
  State during(const State& s, double bend, double t) const noexcept;
  bool between(const State& s, double bend) noexcept;
  Run run(State s, double target, std::size_t level, std::size_t most) noexcept;
  void choose() noexcept;
  void look(double time) noexcept;

  const TimedPath& path_;
  std::span<const MotionLimits> limits_;  // that hold now
  std::span<const MotionLimits> own_limits_;
  std::vector<MotionLimits> hard_limits_;
  double period_, back_ = 1;
  State state_;
  double bend_ = 0, target_ = 0, wanted_ = 0;
  std::size_t level_ = 0, level_to_try_ = 0, cycles_ = 0;
  bool settled_ = true, anew_ = false;
  std::vector<double> position_, velocity_, acceleration_, jerk_;  // planned, at the time looked at
  std::vector<double> jumps_;  // times at which planned jerks jump, ascending
  std::size_t hint_ = 0;
};

}  // namespace polyarm::trajectory
