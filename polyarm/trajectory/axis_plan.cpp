#include "polyarm/trajectory/axis_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::trajectory {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSameTime = 1e-12;  // relative: rounding of a duration
// Relative to the distance in which jerk alone stops full speed: the rounding error of a thousand sampled
// states. Correcting it would take its cube root longer.
constexpr double kSampling = 1e-14;

bool finite(const MotionState& s) {
  return std::isfinite(s.position) && std::isfinite(s.velocity) && std::isfinite(s.acceleration);
}
bool finite(const MotionLimits& l) {
  return std::isfinite(l.max_velocity) && std::isfinite(l.max_acceleration) && std::isfinite(l.max_jerk) &&
         std::isfinite(l.min_velocity) && std::isfinite(l.min_acceleration);
}
bool finite(const MotionState& start, const MotionState& target, const MotionLimits& l) {
  // One sum first; the single numbers are only checked if it is too large.
  const double sum = start.position + start.velocity + start.acceleration + target.position +
                     target.velocity + target.acceleration + l.max_velocity + l.max_acceleration +
                     l.max_jerk + l.min_velocity + l.min_acceleration;
  return std::isfinite(sum) || (finite(start) && finite(target) && finite(l));
}
bool rests(const MotionState& s) {
  return s.velocity == 0 && s.acceleration == 0;
}
bool on_their_sides(const MotionLimits& l) {
  return l.max_velocity > 0 && l.max_acceleration > 0 && l.max_jerk > 0 && l.min_velocity < 0 &&
         l.min_acceleration < 0;
}

/// True if a motion within the limits can reach velocity `v` and acceleration `a`, with jerk 1.
bool reachable(double v, double a, double fast, double back, double up, double down) {
  const double room = kRounding * (fast + back), before = v - a * std::abs(a) / 2;
  return a <= up * (1 + kRounding) && a >= -down * (1 + kRounding) && std::max(v, before) <= fast + room &&
         std::min(v, before) >= -back - room;
}

}  // namespace

MotionStatus AxisPlan::prepare(const MotionState& start, const MotionState& target, const MotionLimits& l,
                               TargetKind kind) noexcept {
  if (!finite(start, target, l)) return MotionStatus::bad_number;
  if (!on_their_sides(l)) return MotionStatus::bad_limit;
  const double per = 1 / l.max_jerk;
  const double fast = l.max_velocity * per, back = -l.min_velocity * per;
  const double up = l.max_acceleration * per, down = -l.min_acceleration * per;
  distance_ = (target.position - start.position) * per;
  slack_ = kRounding * (std::abs(target.position) + std::abs(start.position)) * per;
  from_ = &start, to_ = &target, jerk_ = l.max_jerk, kind_ = kind;
  brake_.count = 0, brake_.total = 0, count_ = 0;
  reach_.time = -1;
  rests_ = kind == TargetKind::position && rests(start) && rests(target);
  if (rests_) {
    listed_ = false;
    find_first_at_rest({fast, up, down}, {back, down, up});
    return MotionStatus::ok;
  }
  const double v1 = target.velocity * per, a1 = target.acceleration * per;
  if (!reachable(v1, a1, fast, back, up, down)) return MotionStatus::target_outside;
  brake_.at = {0, start.velocity * per, start.acceleration * per};
  brake_.run(fast, back, up, down);
  ends_ = {brake_.at.v, brake_.at.a, std::clamp(v1, -back, fast), std::clamp(a1, -down, up)};
  upper_bounds_ = {fast, up, down}, lower_bounds_ = {back, down, up};
  distance_ -= brake_.at.p;
  speeds_ = std::abs(ends_.v0) + std::abs(ends_.v1);
  slack_ += kSampling * fast * std::sqrt(fast);
  listed_ = has_upper_ = has_lower_ = false;
  times_of_ends_ = AxisTimes::of(ends_, up, down);
  kind == TargetKind::position ? find_first() : list_times_of_velocity();
  return MotionStatus::ok;
}

const UpperReach& AxisPlan::upper() noexcept {
  if (!has_upper_) upper_.set(ends_, upper_bounds_, times_of_ends_, false), has_upper_ = true;
  return upper_;
}

const UpperReach& AxisPlan::lower() noexcept {
  if (!has_lower_) lower_.set(ends_.mirrored(), lower_bounds_, times_of_ends_, true), has_lower_ = true;
  return lower_;
}

void AxisPlan::find_first() noexcept {
  if (times_of_ends_.has_island()) return list_times();
  const double shortest = times_of_ends_.shortest, begin = upper().reach(shortest);
  at_once_ = close(begin, shortest);
  if (at_once_) {
    first_ = shortest, share_ = 1;
    return;
  }
  share_ = distance_ > begin ? 1 : 0;
  first_ = share_ > 0 ? upper().first_time(distance_) : lower().first_time(-distance_);
  if (!(first_ >= shortest * (1 - kSameTime) && first_ < kInfinity)) return list_times();
  first_ = std::max(first_, shortest);
}

/// From rest to rest, the two ends of the interval lie on either side of zero, and any fraction of one of
/// them is a motion within the limits: one side is enough.
void AxisPlan::find_first_at_rest(const AxisBounds& upwards, const AxisBounds& downwards) noexcept {
  share_ = distance_ > 0 ? 1 : 0;
  upper_.set_between_rests(distance_ > 0 ? upwards : downwards);
  first_ = std::abs(distance_) > slack_ ? upper_.first_time(std::abs(distance_)) : 0;
}

// --- all durations

void AxisPlan::list_times_of_velocity() noexcept {
  listed_ = true;
  upper(), lower();
  if (times_of_ends_.has_island()) times_[count_++] = {times_of_ends_.shortest, times_of_ends_.island};
  times_[count_++] = {times_of_ends_.mainland, kInfinity};
}

void AxisPlan::list_times() noexcept {
  listed_ = true;
  if (times_of_ends_.has_island()) list_times(times_of_ends_.shortest, times_of_ends_.island);
  list_times(times_of_ends_.mainland, kInfinity);
}

/// The times between `first` and `last` at which the distance is in the interval.
void AxisPlan::list_times(double first, double last) noexcept {
  const double begin = upper().reach(first);
  const bool at_once = close(begin, first);
  if (at_once) distance_ = begin;
  std::array<double, UpperReach::kMostRoots> over, under;
  const std::size_t overs = upper().times_of(distance_, first, last, over);
  const std::size_t unders = lower().times_of(-distance_, first, last, under);
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
    if (b == kInfinity || reaches(a + (b - a) / 2, slack_)) add(a, b);
  }
  if (last < kInfinity && close(upper().reach(last), last)) add(last, last);
}

/// At the ends of the times only one motion exists, and rounding decides whether it arrives.
bool AxisPlan::close(double reach, double t) const noexcept {
  return std::abs(reach - distance_) <= slack_ + kRounding * (std::abs(reach) + 10 * speeds_ * t);
}

void AxisPlan::add(double first, double last) noexcept {
  if (count_ > 0 && first <= times_[count_ - 1].last)
    times_[count_ - 1].last = std::max(times_[count_ - 1].last, last);
  else if (count_ < times_.size())
    times_[count_++] = {first, last};
}

const AxisPlan::Reach& AxisPlan::reach(double t) noexcept {
  if (reach_.time == t) return reach_;
  if (rests_) return reach_ = {t, 0, upper_.reach(t)};
  return reach_ = {t, -lower().reach(t), upper().reach(t)};
}

bool AxisPlan::reaches(double t, double slack) noexcept {
  const Reach& r = reach(t);
  return r.high >= distance_ - slack && r.low <= distance_ + slack;
}

double AxisPlan::arrival(double t) noexcept {
  if (!listed_) {
    const double first = brake_.total + first_;
    if (t <= first) return first;
    if (rests_) return t;
    // The rounding error of an immediate arrival is corrected as soon as there is time for it.
    if (reaches(t - brake_.total, at_once_ ? slack_ : 0)) return t;
    list_times();
  }
  for (std::size_t i = 0; i < count_; ++i)
    if (t <= (brake_.total + times_[i].last) * (1 + 1e-14))
      return std::max(t, brake_.total + times_[i].first);
  return kInfinity;
}

/// `t`, or the end of an interval that it misses only by rounding.
double AxisPlan::nearest(double t) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (t < times_[i].first) return t > times_[i].first * (1 - 1e-9) || i == 0 ? times_[i].first : t;
    if (t <= times_[i].last) return t;
    if (t <= times_[i].last * (1 + kSameTime)) return times_[i].last;
  }
  return t;
}

// --- the motion

void AxisPlan::build(double duration, AxisMotion& out) noexcept {
  out.start(*from_);
  for (std::size_t i = 0; i < brake_.count; ++i) out.append(brake_.time[i], brake_.jerk[i] * jerk_);
  double t = duration - brake_.total;
  MotionState end = *to_;
  if (kind_ == TargetKind::velocity) {
    build_to_velocity(std::max(times_of_ends_.shortest, nearest(t)), out);
    end.position = out.end_.position;
  } else if (rests_) {
    build_between_rests(std::max(t, first_), out);
  } else if (!listed_ && t <= first_ * (1 + 1e-15)) {
    share_ > 0 ? append(upper().phases(first_), jerk_, out) : append(lower().phases(first_), -jerk_, out);
  } else {
    if (listed_) t = std::max(times_of_ends_.shortest, nearest(t));
    const Reach& r = reach(t);
    mix(t, r.high > r.low ? std::clamp((distance_ - r.low) / (r.high - r.low), 0.0, 1.0) : 1.0, out);
  }
  out.finish(end, duration);
}

void AxisPlan::build_between_rests(double t, AxisMotion& out) noexcept {
  double jerk = share_ > 0 ? jerk_ : -jerk_;
  if (t > first_) jerk *= std::min(1.0, std::abs(distance_) / upper_.reach(t));
  append(upper_.phases(t), jerk, out);
}

void AxisPlan::build_to_velocity(double t, AxisMotion& out) noexcept {
  const double spare = t - times_of_ends_.shortest;
  const bool waits_first = to_->acceleration != 0 && spare > 0 && brake_.at.a == 0;
  if (to_->acceleration != 0 && !waits_first) return mix(t, 0.5, out);
  if (waits_first) out.append(spare, 0);
  append(upper().phases(times_of_ends_.shortest), jerk_, out);
  if (!waits_first) out.append(spare, 0);
}

void AxisPlan::append(const JerkPhases& phases, double jerk, AxisMotion& out) const noexcept {
  for (std::size_t i = 0; i < JerkPhases::kMost; ++i) out.append(phases.time[i], jerk * phases.jerk[i]);
}

/// share × the upper end of the interval + (1 - share) × the lower one.
void AxisPlan::mix(double t, double share, AxisMotion& out) noexcept {
  if (share >= 1) return append(upper().phases(t), jerk_, out);
  if (share <= 0) return append(lower().phases(t), -jerk_, out);
  const JerkPhases high = upper().phases(t), low = lower().phases(t);
  const double of_high = share * jerk_, of_low = (1 - share) * jerk_;
  std::size_t i = 0, j = 0;
  double left_high = high.time[0], left_low = low.time[0];
  while (i < JerkPhases::kMost && j < JerkPhases::kMost) {
    const double step = std::min(left_high, left_low);
    out.append(step, of_high * JerkPhases::jerk[i] - of_low * JerkPhases::jerk[j]);
    left_high -= step;
    left_low -= step;
    if (left_high <= 0) left_high = ++i < JerkPhases::kMost ? high.time[i] : 0;
    if (left_low <= 0) left_low = ++j < JerkPhases::kMost ? low.time[j] : 0;
  }
}

}  // namespace polyarm::trajectory
