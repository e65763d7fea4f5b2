#include "polyarm/timing/path_override.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::timing {
namespace {

/// Fractions of a limit for choosing and for accepting f''. The rest covers what may happen between two
/// checked times. If the plan itself uses more than the fraction, it may keep that, but gets nothing in
/// addition.
struct Room {
  double share;
  double most(double own, double limit) const noexcept {
    return std::max(share * limit, own + kRounding * limit);
  }
  static constexpr double kRounding = 1e-9;
};
constexpr Room kChosen{0.999}, kAccepted{0.9997};
constexpr double kBetween = 2e-4;  // of a limit: for what may happen between two checked times
// Limits of the factor's rates where the joints hardly move and would allow anything: 0 to 1 in about 20 ms.
constexpr double kMostRate = 50, kMostBend = 20000;
constexpr double kMostLooks = 32;  // checked times in one step, in addition to the table's nodes
constexpr double kSpacing = 1e-3;  // s of the plan between two rows of the table
/// Reductions of a bend that both ends of a step allow, because a time in between may allow less.
constexpr double kALittleLess[] = {0, 0.003};
constexpr double kSameFactor = 1e-12;  // factors that differ less are equal
constexpr double kNearlyThere = 1e-6;  // factor difference at which a way's end counts as the target
constexpr double kLeastBoldness = 1.0 / 64;
constexpr std::size_t kPushSteps = 12, kLeastPush = 4, kMostPush = 256;  // cycles

double sign(double x) noexcept {
  return x < 0 ? -1 : 1;
}

std::span<const trajectory::MotionLimits> checked(std::span<const trajectory::MotionLimits> limits,
                                                  const TimedPath& path, double period) {
  if (limits.size() != path.joints())
    throw Error("wrong-size", "limits for " + std::to_string(limits.size()) + " joints, the path has " +
                                  std::to_string(path.joints()));
  if (!(period > 0)) throw Error("bad-limit", "the control period is " + std::to_string(period) + " s");
  return limits;
}

}  // namespace

PathOverride::PathOverride(const TimedPath& path, std::span<const trajectory::MotionLimits> limits,
                           double period)
    : path_(path), table_(path, checked(limits, path, period), kSpacing), period_(period) {
  for (const trajectory::MotionLimits& l : limits)
    back_ = std::min({back_, -l.min_velocity / l.max_velocity, -l.max_velocity / l.min_velocity}),
    ramp_ = std::max(ramp_, std::max(l.max_acceleration, -l.min_acceleration) / l.max_jerk);
  std::size_t hint = 0;
  const PathMotion start = path.profile().at(0, hint);
  if (start.speed != 0 || start.acceleration != 0) back_ = 0;
  own_limits_ = PlannedRows::limits_of(limits, 1), hard_limits_ = PlannedRows::limits_of(limits, kHarder);
  for (auto* rows : {&here_, &there_, &inside_}) rows->resize(table_.blocks());
  for (auto* v : {&position_, &velocity_, &acceleration_}) v->resize(limits.size());
}

/// The state after part of a cycle.
PathOverride::State PathOverride::during(const State& s, double bend, double t) const noexcept {
  return {std::clamp(s.time + t * (s.factor + t * (s.rate / 2 + t * bend / 6)), 0.0, path_.duration()),
          s.factor + t * (s.rate + t * bend / 2), s.rate + t * bend};
}

/// The time, in s after `s`, at which the plan's time is `at`, if the plan's time is `end` after `t` s.
double PathOverride::when(const State& s, double bend, double at, double t, double end) const noexcept {
  double x = t * (at - s.time) / (end - s.time);
  for (int newton = 0; newton < 2; ++newton) {
    const double speed = s.factor + x * (s.rate + x * bend / 2);
    const double off = s.time + x * (s.factor + x * (s.rate / 2 + x * bend / 6)) - at;
    if (speed != 0) x = std::clamp(x - off / speed, 0.0, t);
  }
  return x;
}

void PathOverride::look(double time, std::vector<Rows>& out) noexcept {
  node_ = table_.before(time, node_);
  table_.between(node_, time, out.data());
}

/// The largest f'' in a direction for these rows, factor and rate, if f'' acts for `t` s.
double PathOverride::most_bend(const Rows* rows, double factor, double rate, double t,
                               double direction) const noexcept {
  const std::vector<PlannedRows::Limits>& limits = motion_.hard ? hard_limits_ : own_limits_;
  const double square = factor * factor, cube = square * factor;
  double most[PlannedRows::kWidth];
  std::fill(std::begin(most), std::end(most), kMostBend);
  for (std::size_t b = 0; b < limits.size(); ++b) {
    const Rows& r = rows[b];
    const PlannedRows::Limits& l = limits[b];
    for (std::size_t i = 0; i < PlannedRows::kWidth; ++i) {
      const double own = r.jerk[i] * cube, turn = 3 * r.acceleration[i] * factor;
      const double slope = direction * (r.velocity[i] + turn * t), jerk = own + turn * rate;
      const double up = kChosen.most(own, l.jerk[i]) - jerk, down = kChosen.most(-own, l.jerk[i]) + jerk;
      most[i] = std::min(most[i], (slope > 0 ? up : down) / (std::abs(slope) + 1e-30));
      const double a = r.acceleration[i] * square, now = a + r.velocity[i] * rate;
      const double gain = direction * r.velocity[i] * t;
      const double above = kChosen.most(a, l.high[i]) - now, below = kChosen.most(-a, -l.low[i]) + now;
      most[i] = std::min(most[i], (gain > 0 ? above : below) / (std::abs(gain) + 1e-30));
    }
  }
  return *std::min_element(std::begin(most), std::end(most));
}

/// The largest f'' in a direction for `t` s that both ends and the jumps between them allow.
double PathOverride::boldest(const State& s, double t, double direction) noexcept {
  const double end = std::clamp(s.time + t * (s.factor + t * s.rate / 2), 0.0, path_.duration());
  look(s.time, here_);
  const std::size_t node = node_;
  look(end, there_);
  double most = std::min({most_bend(here_.data(), s.factor, s.rate, 0, direction),
                          most_bend(there_.data(), s.factor + t * s.rate, s.rate, t, direction),
                          (kMostRate - direction * s.rate) / t});
  const std::size_t first = std::min(node, node_), last = std::max(node, node_);
  for (std::size_t k = first + 1; k <= last; ++k) {
    if (table_.time(k) != table_.time(k - 1)) continue;
    const double part = std::clamp(t * (table_.time(k) - s.time) / (end - s.time), 0.0, t);
    for (const std::size_t side : {k - 1, k})
      most = std::min(most, most_bend(table_.at(side), s.factor + part * s.rate, s.rate, part, direction));
  }
  return direction * std::max(most, -kMostBend);
}

/// True if the limits hold with this factor, rate and f''.
bool PathOverride::within(const Rows* rows, double factor, double rate, double bend) const noexcept {
  const std::vector<PlannedRows::Limits>& limits = motion_.hard ? hard_limits_ : own_limits_;
  const double square = factor * factor, cube = square * factor, turn = 3 * factor * rate;
  double over[PlannedRows::kWidth] = {};
  for (std::size_t b = 0; b < limits.size(); ++b) {
    const Rows& r = rows[b];
    const PlannedRows::Limits& l = limits[b];
    for (std::size_t i = 0; i < PlannedRows::kWidth; ++i) {
      const double own = r.acceleration[i] * square, a = own + r.velocity[i] * rate;
      const double own_jerk = r.jerk[i] * cube,
                   j = own_jerk + r.acceleration[i] * turn + r.velocity[i] * bend;
      over[i] =
          std::max({over[i], a - kAccepted.most(own, l.high[i]), -a - kAccepted.most(-own, -l.low[i]),
                    j - kAccepted.most(own_jerk, l.jerk[i]), -j - kAccepted.most(-own_jerk, l.jerk[i])});
    }
  }
  return *std::max_element(std::begin(over), std::end(over)) <= 0;
}

/// The number of parts of `t` s at this f'' in which the jerk is nearly linear. Derived from the second time
/// derivative of the rows, with the planned acceleration and jerk at their limits.
double PathOverride::looks(const State& s, const State& end, double bend, double t) const noexcept {
  const double f = std::max(std::abs(s.factor), std::abs(end.factor)), most = std::abs(bend);
  const double rate = std::max(std::abs(s.rate), std::abs(end.rate));
  const double curve = 10 * ramp_ * rate * most + 12 * f * rate * rate + 10 * f * f * most;
  return std::ceil(t * std::sqrt(curve / (8 * kBetween)));
}

/// True if the limits hold for `t` s of this f''. Checks both ends, enough times between them, and every node
/// of the table that is passed.
bool PathOverride::keeps(const State& s, double bend, double t) noexcept {
  const State end = during(s, bend, t);
  if (end.factor > 1 + kSameFactor || end.factor < -back_ - kSameFactor) return false;
  const auto kept = [&](double part) {
    const State inside = during(s, bend, part * t);
    look(inside.time, inside_);
    return within(inside_.data(), inside.factor, inside.rate, bend);
  };
  const double parts = looks(s, end, bend, t);
  if (parts > kMostLooks || !kept(0) || !kept(1)) return false;
  for (double k = 1; k < parts; ++k)
    if (!kept(k / parts)) return false;
  const double low = std::min(s.time, end.time), high = std::max(s.time, end.time);
  std::size_t node = table_.before(low, node_);
  if (table_.time(node) < low) ++node;
  bool passed = false;
  for (; node < table_.nodes() && table_.time(node) <= high; ++node) {
    passed = true;
    const double part = high > low ? when(s, bend, table_.time(node), t, end.time) : 0;
    const double rate = s.rate + part * bend;
    if (!within(table_.at(node), s.factor + part * (s.rate + part * bend / 2), rate, bend)) return false;
  }
  return passed || parts > 1 || kept(0.5);
}

/// The same for a bend that is as large in a direction as both ends allow, or slightly less.
bool PathOverride::keeps_nearly(const State& s, double& bend, double t, double direction) noexcept {
  for (const double less : kALittleLess) {
    const double tried = bend - direction * less * std::abs(bend);
    if (!keeps(s, tried, t)) continue;
    bend = tried;
    return true;
  }
  return false;
}

/// Finds a way to a steady factor: `push` cycles in `direction` as fast as the rows allow, then to rest as
/// soon as they allow. False if that exceeds the limits.
bool PathOverride::recover(State s, Way& way, double direction, std::size_t push) noexcept {
  way.steps = 0;
  way.cycles = (push + kPushSteps - 1) / kPushSteps;
  const std::size_t pushed = push > 0 ? push / way.cycles : 0;
  for (; way.steps < kMostSteps; ++way.steps) {
    const bool on = way.steps < pushed;
    if (!on && s.rate == 0) break;
    if ((s.time >= path_.duration() && s.factor >= 0) || (s.time <= 0 && s.factor < 0)) break;
    const double towards = on ? direction : -sign(s.rate);
    if (way.cycles == 0) {
      way.cycles = 1;
      const double most = boldest(s, period_, towards), cycles = std::abs(s.rate / most) / period_;
      if (towards * most > 0) way.cycles = std::size_t(std::clamp(std::ceil(cycles / 32), 1.0, 64.0));
    }
    const double t = period_ * double(way.cycles), rest = -s.rate / t;
    double bend = boldest(s, t, towards);
    const bool last = !on && towards * rest <= towards * bend;
    if (last) bend = rest;
    if (last ? !keeps(s, bend, t) : !keeps_nearly(s, bend, t, towards)) return false;
    s = during(s, bend, t);
    if (last) s.rate = 0;
    way.bends[way.steps] = bend;
  }
  way.end = s.factor;
  return way.steps < kMostSteps;
}

void PathOverride::begin(double time, double factor) noexcept {
  motion_ = {};
  motion_.at = {std::clamp(time, 0.0, path_.duration()), std::clamp(factor, -back_, 1.0), 0};
  motion_.out.end = motion_.at.factor;
  bend_ = 0;
}

void PathOverride::take(double bend, const Way& way) noexcept {
  bend_ = bend;
  motion_.at = during(motion_.at, bend, period_);
  motion_.out = way;
  motion_.step = motion_.cycle = 0;
}

/// Follows the known way for one cycle. Keeps the factor if the way is finished.
void PathOverride::follow_way_out() noexcept {
  Motion& m = motion_;
  const bool any = m.step < m.out.steps;
  bend_ = any ? m.out.bends[m.step] : 0;
  m.at = during(m.at, bend_, period_);
  if (!any) return;
  if (++m.cycle == m.out.cycles) ++m.step, m.cycle = 0;
  if (m.step == m.out.steps) m.at.rate = 0, m.at.factor = m.out.end;
}

/// Tries to reach the target in two cycles, if the rows allow it.
bool PathOverride::arrive(double target) noexcept {
  const State& s = motion_.at;
  const double t = period_, first = (target - s.factor - 1.5 * t * s.rate) / (t * t);
  const double second = -(s.rate + first * t) / t;
  if (!(std::abs(first) <= kMostBend && std::abs(second) <= kMostBend)) return false;
  if (!keeps(s, first, t) || !keeps(during(s, first, t), second, t)) return false;
  tried_.bends[0] = second, tried_.steps = tried_.cycles = 1, tried_.end = target;
  take(first, tried_);
  return true;
}

/// Finds an f'' towards the target after which a way to a steady factor exists, or a way past an obstacle.
bool PathOverride::attempt(double target) noexcept {
  Motion& m = motion_;
  const double direction = sign(target - m.out.end), t = period_;
  const double calm = m.step < m.out.steps ? m.out.bends[m.step] : 0;
  const double most = boldest(m.at, t, direction) - calm;
  double more = m.boldness * most;
  for (std::size_t tries = 0; tries < kMostTries; ++tries) {
    if (!(direction * more > 0)) return false;
    double bend = calm + more;
    const bool safe =
        keeps_nearly(m.at, bend, t, direction) && recover(during(m.at, bend, t), tried_, direction, 0);
    const double beyond = safe ? direction * (tried_.end - target) : 0;
    if (safe && beyond <= kSameFactor) {
      take(bend, tried_);
      m.boldness = std::min(1.0, 2 * m.boldness);
      return true;
    }
    if (safe) {  // the way ends beyond the target: reduces f'' by the part that causes it
      more -= direction * beyond / (t * (t / 2 + t * double(tried_.steps * tried_.cycles)));
      continue;
    }
    if (tries == 0 && push_past(calm + most, direction, target)) return true;
    more /= 2;
    m.boldness = std::max(m.boldness / 2, kLeastBoldness);
  }
  return false;
}

/// Continues for some cycles as far as the rows allow, then to a steady factor. With too few cycles it does
/// not pass the obstacle, with too many it passes the target; searches for the number in between.
bool PathOverride::push_past(double bend, double direction, double target) noexcept {
  Motion& m = motion_;
  if (!keeps_nearly(m.at, bend, period_, direction)) return false;
  const State next = during(m.at, bend, period_);
  std::size_t few = 0, many = 0;
  for (std::size_t tries = 0; tries < kMostPushes; ++tries) {
    if (!recover(next, tried_, direction, m.push)) {
      few = m.push;
    } else if (direction * (tried_.end - target) > kSameFactor) {
      many = m.push;
    } else {
      take(bend, tried_);
      return true;
    }
    if (many == 0)
      m.push = m.push >= kMostPush ? kLeastPush : 2 * m.push;
    else if (few == 0 || few >= many)
      m.push = std::max(many / 2, kLeastPush);
    else
      m.push = (few + many) / 2;
  }
  return false;
}

double PathOverride::allowed_target(double target) const noexcept {
  if (!(target > -2) || motion_.hard) return 0;
  if (target < 0 && motion_.at.time <= 0) return 0;
  return std::clamp(target, -back_, 1.0);
}

void PathOverride::advance(double target, bool immediate) noexcept {
  Motion& m = motion_;
  if (immediate ? !stands() : stands()) m.hard = immediate;
  target = allowed_target(target);
  const bool settled = m.at.rate == 0 && std::abs(m.at.factor - target) <= kSameFactor;
  const bool leads_there = m.step < m.out.steps && std::abs(target - m.out.end) <= kNearlyThere;
  if (settled) m.at.factor = m.out.end = target, m.boldness = 1;
  // A motion that ends within this cycle can hardly change any more, and nothing is checked within the cycle.
  const bool ends = m.at.time + period_ * (m.at.factor + period_ / 2 * m.at.rate) >= path_.duration();
  if (settled || leads_there || ends || !(arrive(target) || attempt(target))) follow_way_out();
  if (m.at.time <= 0 && m.at.factor < 0) {  // back at the start, where the plan rests
    m.at.factor = m.at.rate = m.out.end = 0;
    m.step = m.out.steps = 0;
  }
}

void PathOverride::sample(std::span<double> position, std::span<double> velocity,
                          std::span<double> acceleration) noexcept {
  const State& s = motion_.at;
  path_.sample(s.time, position_, velocity_, acceleration_, {}, hint_);
  std::copy_n(position_.begin(), position.size(), position.begin());
  for (std::size_t j = 0; j < velocity.size(); ++j) velocity[j] = velocity_[j] * s.factor;
  for (std::size_t j = 0; j < acceleration.size(); ++j)
    acceleration[j] = acceleration_[j] * s.factor * s.factor + velocity_[j] * s.rate;
}

StoppingWay PathOverride::stopping() noexcept {
  constexpr std::size_t kMostCycles = 100'000;
  const Motion before = motion_;
  const double bend = bend_;
  std::size_t cycles = 0, hint = 0;
  for (; cycles < kMostCycles && !stands() && !finished(); ++cycles) advance(0);
  const StoppingWay out{
      double(cycles) * period_,
      path_.profile().at(motion_.at.time, hint).s - path_.profile().at(before.at.time, hint).s,
      stands() || finished()};
  motion_ = before, bend_ = bend;
  return out;
}

}  // namespace polyarm::timing
