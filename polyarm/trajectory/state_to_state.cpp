#include "polyarm/trajectory/state_to_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/trajectory/axis_reach.hpp"
#include "polyarm/trajectory/constant_jerk.hpp"

namespace polyarm::trajectory {

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool finite(const MotionState& s) {
  return std::isfinite(s.position) && std::isfinite(s.velocity) && std::isfinite(s.acceleration);
}
bool finite(const MotionLimits& l) {
  return std::isfinite(l.max_velocity) && std::isfinite(l.max_acceleration) && std::isfinite(l.max_jerk) &&
         std::isfinite(l.min_velocity) && std::isfinite(l.min_acceleration);
}
bool right_side_of_zero(const MotionLimits& l) {
  return l.max_velocity > 0 && l.max_acceleration > 0 && l.max_jerk > 0 && l.min_velocity < 0 &&
         l.min_acceleration < 0;
}

/// Brings an axis back inside its limits, in units in which the jerk is 1.
struct Brake : JerkState {
  static constexpr std::size_t kMost = 7;
  std::array<double, kMost> time{}, jerk{};
  std::size_t count = 0;
  double total = 0;

  void pass(double t, double j) noexcept {
    if (!(t > 0) || count == kMost) return;
    time[count] = t;
    jerk[count++] = j;
    total += t;
    static_cast<JerkState&>(*this) = after(*this, t, j);
  }
  void into_acceleration(double most, double least) noexcept {
    if (a > most) pass(a - most, -1), a = most;
    if (a < least) pass(least - a, 1), a = least;
  }
  /// Where the velocity passes `bound`, or will since the acceleration cannot be taken back in time: over to
  /// the other direction, until the velocity is at the bound. `side`: 1 for an upper bound, -1 for a lower
  /// one; `deceleration`: the magnitude that may be used; `width`: to the other bound, which is not passed.
  void into_velocity(double side, double bound, double deceleration, double width) noexcept {
    const double beyond = side * (v - bound), towards = side * a;
    const double slack = kRounding * width;
    if (beyond <= slack && (towards <= 0 || beyond + towards * towards / 2 <= slack)) return;
    const double most = std::min(deceleration, root(2 * width));
    const double turn = root(towards * towards + 2 * beyond);  // magnitude of the acceleration at the bound
    if (turn <= most) {
      pass(towards + turn, -side);
    } else {
      pass(towards + most, -side);
      if (side * a < 0) pass((v - bound) / -a, 0);
    }
    v = bound;
  }
};
}  // namespace

const char* name(MotionStatus status) noexcept {
  switch (status) {
    case MotionStatus::ok:
      return "ok";
    case MotionStatus::wrong_size:
      return "wrong size";
    case MotionStatus::bad_number:
      return "a number is not finite";
    case MotionStatus::bad_limit:
      return "a limit is on the wrong side of zero";
    case MotionStatus::target_outside:
      return "the target's velocity and acceleration cannot be reached within the limits";
  }
  return "";
}

// --- motion of one axis -----------------------------------------------------------------------------------

namespace {
MotionState passed(const MotionState& s, double t, double jerk) noexcept {
  const JerkState end = after({s.position, s.velocity, s.acceleration}, t, jerk);
  return {end.p, end.v, end.a};
}
}  // namespace

void AxisMotion::start(const MotionState& at) noexcept {
  count_ = 0;
  duration_ = 0;
  end_ = at;
}

void AxisMotion::append(double time, double jerk) noexcept {
  if (!(time > 0) || count_ == kMostPieces) return;
  pieces_[count_++] = {duration_, end_, jerk};
  end_ = passed(end_, time, jerk);
  duration_ += time;
}

void AxisMotion::finish(const MotionState& at, double duration) noexcept {
  if (count_ == 0) pieces_[count_++] = {0, end_, 0};
  end_ = at;
  duration_ = duration;
}

MotionState AxisMotion::at(double t) const noexcept {
  if (!(t < duration_)) {
    const double beyond = t - duration_;
    return {end_.position + end_.velocity * (beyond > 0 ? beyond : 0), end_.velocity,
            beyond > 0 ? 0 : end_.acceleration};
  }
  if (!(t > 0)) return pieces_[0].state;
  std::size_t i = count_ - 1;
  while (i > 0 && pieces_[i].begin > t) --i;
  return passed(pieces_[i].state, t - pieces_[i].begin, pieces_[i].jerk);
}

// --- one axis of a plan -----------------------------------------------------------------------------------

/// An axis in its own units: its jerk is 1, the larger of its accelerations too.
struct StateToState::Axis {
  double second, metre;  ///< units: s, and that of the axis
  MotionState from, to;  ///< as given
  Brake brake;
  double distance;  ///< after braking
  double slack;     ///< what rounding may make of a distance
  double speeds;    ///< magnitudes of the velocities at both ends, together
  UpperReach upper, lower;
  struct Interval {
    double first, last;
  };
  std::array<Interval, 12> times;  ///< in which the axis can arrive, after braking; the last has no end
  std::size_t count = 0;

  static bool reachable(const MotionState& target, const MotionLimits& l) noexcept {
    const double v = target.velocity, a = target.acceleration;
    const double room = kRounding * (l.max_velocity - l.min_velocity);
    const double before = v - a * std::abs(a) / (2 * l.max_jerk);
    return a <= l.max_acceleration * (1 + kRounding) && a >= l.min_acceleration * (1 + kRounding) &&
           std::max(v, before) <= l.max_velocity + room && std::min(v, before) >= l.min_velocity - room;
  }

  static Axis make(const MotionState& start, const MotionState& target, const MotionLimits& l,
                   TargetKind kind) noexcept {
    const double most = std::max(l.max_acceleration, -l.min_acceleration);
    const double second = most / l.max_jerk, metre = most * second * second;
    const double speed = metre / second;
    const double up = l.max_acceleration / most, down = -l.min_acceleration / most;
    const double fast = l.max_velocity / speed, back = -l.min_velocity / speed;
    Brake brake;
    brake.v = start.velocity / speed;
    brake.a = start.acceleration / most;
    brake.into_acceleration(up, -down);
    brake.into_velocity(1, fast, down, fast + back);
    brake.into_velocity(-1, -back, up, fast + back);
    brake.into_velocity(1, fast, down, fast + back);  // which the brake may have turned it to
    const UpperReach::Ends ends{brake.v, brake.a, std::clamp(target.velocity / speed, -back, fast),
                                std::clamp(target.acceleration / most, -down, up)};
    Axis out{second,
             metre,
             start,
             target,
             brake,
             (target.position - start.position) / metre - brake.p,
             kRounding * (std::abs(target.position) + std::abs(start.position)) / metre,
             std::abs(ends.v0) + std::abs(ends.v1),
             UpperReach(ends, {fast, up, down}),
             UpperReach({-ends.v0, -ends.a0, -ends.v1, -ends.a1}, {back, down, up}),
             {},
             0};
    kind == TargetKind::position ? out.find_times() : out.find_times_of_velocity();
    return out;
  }

  void find_times_of_velocity() noexcept {
    if (upper.has_island()) times[count++] = {upper.shortest(), upper.island()};
    times[count++] = {upper.mainland(), kInfinity};
  }

  void find_times() noexcept {
    if (upper.has_island()) find_times(upper.shortest(), upper.island());
    find_times(upper.mainland(), kInfinity);
  }

  bool reaches(double t) const noexcept {
    return upper.reach(t) >= distance - slack && -lower.reach(t) <= distance + slack;
  }

  /// The times between `first` and `last` in which the distance is in the interval.
  void find_times(double first, double last) noexcept {
    const double begin = upper.reach(first);
    const bool at_once = close(begin, first);
    if (at_once) distance = begin;
    std::array<double, UpperReach::kMostRoots> over, under;
    const std::size_t overs = upper.times_of(distance, first, last, over);
    const std::size_t unders = lower.times_of(-distance, first, last, under);
    std::array<double, 2 * UpperReach::kMostRoots + 2> edges;
    std::size_t n = 0;
    edges[n++] = first;
    std::merge(over.begin(), over.begin() + overs, under.begin(), under.begin() + unders, edges.begin() + n);
    n += overs + unders;
    edges[n++] = last;
    if (at_once) add(first, first);
    for (std::size_t i = 1; i < n; ++i) {
      const double a = edges[i - 1], b = edges[i];
      if (!(b > a)) continue;
      if (b == kInfinity || reaches(a + (b - a) / 2)) add(a, b);
    }
    if (last < kInfinity && close(upper.reach(last), last)) add(last, last);
  }
  /// At the ends of the times there is one motion only, and rounding alone decides whether it arrives.
  bool close(double reach, double t) const noexcept {
    return std::abs(reach - distance) <= slack + kRounding * (std::abs(reach) + 10 * speeds * t);
  }

  void add(double first, double last) noexcept {
    if (count > 0 && first <= times[count - 1].last)
      times[count - 1].last = std::max(times[count - 1].last, last);
    else if (count < times.size())
      times[count++] = {first, last};
  }

  /// The earliest time not before `t` in which the axis can arrive, all in seconds from the start.
  double arrival(double t) const noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      const double first = (brake.total + times[i].first) * second;
      const double last = (brake.total + times[i].last) * second;
      if (t <= last * (1 + 1e-14)) return std::max(t, first);
    }
    return kInfinity;
  }

  /// Arrives after `duration` seconds, which arrival() has given.
  void build(double duration, TargetKind kind, AxisMotion& out) const noexcept {
    const double jerk_unit = metre / (second * second * second);
    const auto append = [&](double time, double jerk) { out.append(time * second, jerk * jerk_unit); };
    out.start(from);
    for (std::size_t i = 0; i < brake.count; ++i) append(brake.time[i], brake.jerk[i]);
    const double t = std::max(upper.shortest(), nearest(duration / second - brake.total));
    MotionState end = to;
    if (kind == TargetKind::velocity) {
      const double spare = t - upper.shortest();
      const bool waits_first = to.acceleration != 0 && spare > 0 && brake.a == 0;
      if (waits_first) append(spare, 0);
      if (to.acceleration == 0 || waits_first) {
        const JerkPhases direct = upper.phases(upper.shortest());
        for (std::size_t i = 0; i < JerkPhases::kMost; ++i) append(direct.time[i], direct.jerk[i]);
        if (!waits_first) append(spare, 0);
      } else {
        mix(t, 0.5, append);
      }
      end.position = out.end_.position;
    } else {
      const double high = upper.reach(t), low = -lower.reach(t);
      mix(t, high > low ? std::clamp((distance - low) / (high - low), 0.0, 1.0) : 1.0, append);
    }
    out.finish(end, duration);
  }

  /// `t`, or the end of an interval that rounding has made it miss.
  double nearest(double t) const noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      if (t < times[i].first) return t > times[i].first * (1 - 1e-9) || i == 0 ? times[i].first : t;
      if (t <= times[i].last) return t;
      if (t <= times[i].last * (1 + 1e-12)) return times[i].last;
    }
    return t;
  }

  /// share × the upper end of the interval + (1 - share) × the lower one.
  template <typename Append>
  void mix(double t, double share, Append append) const noexcept {
    const JerkPhases high = upper.phases(t), low = lower.phases(t);
    if (share >= 1 || share <= 0) {
      const JerkPhases& one = share >= 1 ? high : low;
      for (std::size_t i = 0; i < JerkPhases::kMost; ++i)
        append(one.time[i], share >= 1 ? one.jerk[i] : -one.jerk[i]);
      return;
    }
    std::size_t i = 0, j = 0;
    double left_high = high.time[0], left_low = low.time[0];
    while (i < JerkPhases::kMost && j < JerkPhases::kMost) {
      const double step = std::min(left_high, left_low);
      append(step, share * high.jerk[i] - (1 - share) * low.jerk[j]);
      left_high -= step;
      left_low -= step;
      if (left_high <= 0) left_high = ++i < JerkPhases::kMost ? high.time[i] : 0;
      if (left_low <= 0) left_low = ++j < JerkPhases::kMost ? low.time[j] : 0;
    }
  }
};

// --- the plan ---------------------------------------------------------------------------------------------

MotionStatus StateToState::plan(std::span<const MotionState> start, std::span<const MotionState> target,
                                std::span<const MotionLimits> limits, const MotionOptions& options) noexcept {
  const std::size_t n = start.size();
  if (n == 0 || n > kMostAxes || target.size() != n || limits.size() != n) return MotionStatus::wrong_size;
  if (!std::isfinite(options.minimum_duration)) return MotionStatus::bad_number;
  for (std::size_t i = 0; i < n; ++i) {
    if (!finite(start[i]) || !finite(target[i]) || !finite(limits[i])) return MotionStatus::bad_number;
    if (!right_side_of_zero(limits[i])) return MotionStatus::bad_limit;
    if (!Axis::reachable(target[i], limits[i])) return MotionStatus::target_outside;
  }
  count_ = n;
  straight_ =
      options.synchronization == Synchronization::phase && plan_straight(start, target, limits, options);
  if (straight_) return MotionStatus::ok;

  alignas(Axis) std::byte room[kMostAxes * sizeof(Axis)];  // an axis cannot be made of nothing
  Axis* const axis = reinterpret_cast<Axis*>(room);
  for (std::size_t i = 0; i < n; ++i)
    new (&axis[i]) Axis(Axis::make(start[i], target[i], limits[i], options.target));
  const double least = std::max(0.0, options.minimum_duration);
  const bool together = options.synchronization != Synchronization::none;
  double common = least;
  for (bool moved = together; moved;) {
    moved = false;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = axis[i].arrival(common);
      moved |= t > common;
      common = t;
    }
  }
  duration_ = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = together ? common : axis[i].arrival(least);
    axis[i].build(t, options.target, motions_[i]);
    duration_ = std::max(duration_, t);
  }
  return MotionStatus::ok;
}

/// All differences of the states are multiples of one direction: then the motion is that of one axis, with
/// the limits of the axis that allows least.
bool StateToState::plan_straight(std::span<const MotionState> start, std::span<const MotionState> target,
                                 std::span<const MotionLimits> limits,
                                 const MotionOptions& options) noexcept {
  if (options.target != TargetKind::position) return false;
  const std::size_t n = start.size();
  const auto distance = [&](std::size_t i) { return target[i].position - start[i].position; };
  std::size_t lead = 0;
  for (std::size_t i = 1; i < n; ++i)
    if (std::abs(distance(i)) > std::abs(distance(lead))) lead = i;
  if (distance(lead) == 0) return false;
  MotionLimits l = limits[lead];
  std::array<double, kMostAxes> share;
  for (std::size_t i = 0; i < n; ++i) {
    share[i] = distance(i) / distance(lead);
    const auto proportional = [&](double own, double leads) {
      return std::abs(own - share[i] * leads) <= 1e-9 * (std::abs(own) + std::abs(leads));
    };
    if (!proportional(start[i].velocity, start[lead].velocity) ||
        !proportional(start[i].acceleration, start[lead].acceleration) ||
        !proportional(target[i].velocity, target[lead].velocity) ||
        !proportional(target[i].acceleration, target[lead].acceleration))
      return false;
    if (share[i] == 0) continue;
    const bool along = share[i] > 0;
    const MotionLimits& own = limits[i];
    l.max_velocity = std::min(l.max_velocity, (along ? own.max_velocity : own.min_velocity) / share[i]);
    l.min_velocity = std::max(l.min_velocity, (along ? own.min_velocity : own.max_velocity) / share[i]);
    l.max_acceleration =
        std::min(l.max_acceleration, (along ? own.max_acceleration : own.min_acceleration) / share[i]);
    l.min_acceleration =
        std::max(l.min_acceleration, (along ? own.min_acceleration : own.max_acceleration) / share[i]);
    l.max_jerk = std::min(l.max_jerk, own.max_jerk / std::abs(share[i]));
  }
  if (!finite(l) || !right_side_of_zero(l) || !Axis::reachable(target[lead], l)) return false;
  const Axis one = Axis::make(start[lead], target[lead], l, options.target);
  if (one.brake.count > 0) return false;
  duration_ = one.arrival(std::max(0.0, options.minimum_duration));
  one.build(duration_, options.target, motions_[lead]);
  const AxisMotion& model = motions_[lead];
  for (std::size_t i = 0; i < n; ++i) {
    if (i == lead) continue;
    AxisMotion& motion = motions_[i];
    motion.start(start[i]);
    for (std::size_t k = 0; k < model.count_; ++k)
      motion.append((k + 1 < model.count_ ? model.pieces_[k + 1].begin : duration_) - model.pieces_[k].begin,
                    share[i] * model.pieces_[k].jerk);
    motion.finish(target[i], duration_);
  }
  return true;
}

void StateToState::sample(double t, std::span<MotionState> out) const noexcept {
  for (std::size_t i = 0; i < count_ && i < out.size(); ++i) out[i] = motions_[i].at(t);
}

}  // namespace polyarm::trajectory
