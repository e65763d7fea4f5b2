#pragma once
/// Runs along a timed path at any speed: override, hold, resume and backwards, without leaving the path or
/// exceeding a limit. Radians or metres, seconds.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/planned_rows.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Time and distance until the path is at standstill: seconds, and the way along the path in its parameter
/// (negative: backwards).
struct StoppingWay {
  double time = 0, way = 0;
  bool known = true;  ///< false: no standstill after a hundred thousand cycles
};

/// The place on a timed path in the control cycle, and the factor at which the path's time runs: 1 as
/// planned, 0 held, negative backwards. In each cycle the second derivative of the factor is constant, so the
/// joints have limited jerk. The joints follow q(τ), with τ' = f:
///   q' = q̇f, q'' = q̈f² + q̇f', q''' = q⃛f³ + 3q̈ff' + q̇f''
/// (q̇, q̈, q⃛ as planned). A plan within the limits keeps them at any constant f in [0, 1].
///
/// Method: every change of f can be cancelled. There is always a known way from the present state to a steady
/// f that keeps every limit; it is followed if nothing better is found. Each cycle tries a larger f'' towards
/// the target: first as much as the rows above allow, then less. The f'' is accepted if a way to a steady f
/// exists after it and does not pass the target. If this fails, the cause may be a limit that applies only
/// for a short time. Then a way that continues with a large f'' for some cycles is tried as well. Ways are
/// simulated in steps of one cycle, or of several if they are long, on a table of the rows. So a cycle needs
/// a limited number of look-ups, reacts immediately, and never enters a state that it cannot leave. See
/// docs/decisions/0010-timing.md.
///
/// Control thread. advance() allocates nothing, throws nothing, and takes at most kMostTries + kMostPushes
/// runs of at most kMostSteps steps. Keeps a reference to the path.
class PathOverride {
 public:
  static constexpr std::size_t kMostSteps = 96;
  static constexpr std::size_t kMostTries = 3, kMostPushes = 3;
  /// An immediate stop uses this many times the acceleration, and its square times the jerk.
  static constexpr double kHarder = 3;

  /// Not in the control cycle: evaluates the whole path. `limits`: of every joint, at least those that the
  /// path was planned with; `period`: of the control cycle, s. The initial state is held at the start of the
  /// path. Throws Error "wrong-size", "bad-limit".
  PathOverride(const TimedPath& path, std::span<const trajectory::MotionLimits> limits, double period);

  /// Starts at `time` of the plan with a steady `factor`. For a path that is already being followed, or at
  /// standstill.
  void begin(double time, double factor) noexcept;
  /// One cycle towards `target` in [-1, 1] (clamped; NaN counts as 0). Backwards it is limited by the joints'
  /// slower directions; a path that does not begin at rest cannot run backwards. `immediate`: brakes to 0
  /// with harder limits; once begun it ignores the target until standstill.
  void advance(double target, bool immediate = false) noexcept;

  /// Time on the plan, s; the factor and its time derivatives (the second one: during the last cycle).
  double time() const noexcept { return motion_.at.time; }
  double factor() const noexcept { return motion_.at.factor; }
  double rate() const noexcept { return motion_.at.rate; }
  double bend() const noexcept { return bend_; }
  bool finished() const noexcept { return motion_.at.time >= path_.duration(); }
  bool stands() const noexcept { return motion_.at.factor == 0 && motion_.at.rate == 0; }

  /// The present joint state. Spans as with TimedPath::sample, without jerk.
  void sample(std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration) noexcept;
  /// The stop that would follow if the target became 0 now. Simulates the whole stop cycle by cycle: not for
  /// the control cycle.
  StoppingWay stopping() noexcept;

 private:
  struct State {
    double time = 0, factor = 0, rate = 0;
  };
  /// Values of f'', in steps of `cycles` cycles, that bring f to rest at `end`.
  struct Way {
    std::array<double, kMostSteps> bends;
    std::size_t steps = 0, cycles = 1;
    double end = 0;
  };
  /// The state of the motion, and the rest of the known way to a steady factor.
  struct Motion {
    State at;
    Way out;
    std::size_t step = 0, cycle = 0;  // index of the next step and cycle of that way
    double boldness = 1;
    std::size_t push = 16;  // cycles for which a way continues with a large f''
    bool hard = false;
  };
  using Rows = PlannedRows::Rows;

  State during(const State& s, double bend, double t) const noexcept;
  double when(const State& s, double bend, double at, double t, double end) const noexcept;
  void look(double time, std::vector<Rows>& out) noexcept;
  double most_bend(const Rows* rows, double factor, double rate, double t, double direction) const noexcept;
  double boldest(const State& s, double t, double direction) noexcept;
  bool within(const Rows* rows, double factor, double rate, double bend) const noexcept;
  double looks(const State& s, const State& end, double bend, double t) const noexcept;
  bool keeps(const State& s, double bend, double t) noexcept;
  bool keeps_nearly(const State& s, double& bend, double t, double direction) noexcept;
  bool recover(State s, Way& way, double direction, std::size_t push) noexcept;
  bool push_past(double bend, double direction, double target) noexcept;
  bool arrive(double target) noexcept;
  bool attempt(double target) noexcept;
  void follow_way_out() noexcept;
  void take(double bend, const Way& way) noexcept;
  double allowed_target(double target) const noexcept;

  const TimedPath& path_;
  PlannedRows table_;
  std::vector<PlannedRows::Limits> own_limits_, hard_limits_;
  double period_, back_ = 1;
  double ramp_ = 0;  // s: the longest time that a joint needs to reach its acceleration limit at full jerk
  Motion motion_;
  Way tried_;
  double bend_ = 0;
  std::vector<Rows> here_, there_, inside_;  // scratch
  std::vector<double> position_, velocity_, acceleration_;
  std::size_t node_ = 0, hint_ = 0;
};

}  // namespace polyarm::timing
