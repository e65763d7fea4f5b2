#pragma once
/// Runs along a timed path at any speed: override, hold, resume and back, without leaving the path or a
/// limit.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/planned_rows.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Until the path stands still: seconds, and the way along the path (in its parameter; below zero: back).
struct StoppingWay {
  double time = 0, way = 0;
  bool known = true;  ///< false: it did not stand after a hundred thousand cycles
};

/// The place on a timed path as the control cycle moves it, and the factor at which its time runs: 1 as
/// planned, 0 held, below zero back. In each cycle the factor's second derivative is constant, so joints have
/// limited jerk. What the joints do is q(τ), with τ' = f:
///   q' = q̇f,  q'' = q̈f² + q̇f',  q''' = q⃛f³ + 3q̈ff' + q̇f''
/// (q̇, q̈, q⃛ as planned). A plan that keeps the limits keeps them at any constant f in [0, 1].
///
/// Method: whatever moves f can be given up: there is always a way from here to a steady f that keeps every
/// limit, found before and followed where nothing better is. In each cycle a bolder f'' towards the target is
/// tried: first as much as the rows above leave, then less. It is taken when from where it leads there is a
/// way to a steady f again, not beyond the target. Where that cannot be at once, what is in the way may be
/// past when f has changed more: then a way that goes on boldly for some cycles is tried, too. Ways are run
/// through in steps of the cycle, or of several where they are long, on a table of the rows; so a cycle costs
/// a bounded number of looks at the table, acts at once, and never enters what it could not leave.
/// docs/decisions/0010-timing.md.
///
/// Control thread. advance() allocates nothing, throws nothing, and takes at most kMostTries + kMostPushes
/// runs of at most kMostSteps steps. Keeps a reference to the path given.
class PathOverride {
 public:
  static constexpr std::size_t kMostSteps = 96;
  static constexpr std::size_t kMostTries = 3, kMostPushes = 3;
  /// An immediate stop takes this many times the acceleration, and its square times the jerk.
  static constexpr double kHarder = 3;

  /// Outside the cycle: looks at the whole path. `limits`: of every joint, those that the path was planned
  /// with, or higher; `period`: of the control cycle, s. Begins held at the path's start. Throws Error
  /// "wrong-size", "bad-limit".
  PathOverride(const TimedPath& path, std::span<const trajectory::MotionLimits> limits, double period);

  /// From `time` on the plan, at a steady `factor`; for when the path is followed already, or nothing moves.
  void begin(double time, double factor) noexcept;
  /// One cycle on the way to `target` in [-1, 1] (clamped; not a number counts as 0). Backwards it goes no
  /// faster than the joints' slower directions allow, and not at all on a path that does not begin at rest.
  /// `immediate`: brakes to 0 with harder limits; once it does, it goes on until it stands, whatever is asked
  /// meanwhile.
  void advance(double target, bool immediate = false) noexcept;

  /// Where on the planned time, s; the factor and its derivatives by time (the second: during the last
  /// cycle).
  double time() const noexcept { return motion_.at.time; }
  double factor() const noexcept { return motion_.at.factor; }
  double rate() const noexcept { return motion_.at.rate; }
  double bend() const noexcept { return bend_; }
  bool finished() const noexcept { return motion_.at.time >= path_.duration(); }
  bool stands() const noexcept { return motion_.at.factor == 0 && motion_.at.rate == 0; }

  /// What the joints do now. Spans as with TimedPath::sample, jerk left out.
  void sample(std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration) noexcept;
  /// If the target became 0 now. Goes through the whole stop cycle by cycle: not for a control cycle.
  StoppingWay stopping() noexcept;

 private:
  struct State {
    double time = 0, factor = 0, rate = 0;
  };
  /// f'' in steps of `cycles` cycles that bring f to rest, at `end`.
  struct Way {
    std::array<double, kMostSteps> bends;
    std::size_t steps = 0, cycles = 1;
    double end = 0;
  };
  /// What moves, and the way out of it as far as it is left.
  struct Motion {
    State at;
    Way out;
    std::size_t step = 0, cycle = 0;  // of the way out that come next
    double boldness = 1;
    std::size_t push = 16;  // cycles that a way boldly goes on for
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
  double ramp_ = 0;  // s: the longest of a joint's acceleration over its jerk
  Motion motion_;
  Way tried_;
  double bend_ = 0;
  std::vector<Rows> here_, there_, inside_;  // scratch
  std::vector<double> position_, velocity_, acceleration_;
  std::size_t node_ = 0, hint_ = 0;
};

}  // namespace polyarm::timing
