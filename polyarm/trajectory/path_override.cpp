#include "polyarm/trajectory/path_override.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::trajectory {
namespace {

constexpr double kRoom = 0.99;  // of a limit that the law plans with; the rest is for the way between cycles
constexpr double kTolerance = 9e-7;
// Of the factor, where the joints hardly move and leave any room: 0 to 1 in some 20 ms.
constexpr double kMostRate = 50, kMostBend = 20000;
/// How much of the room for f' and for the end of f' the law uses, from the boldest on.
struct Boldness {
  double rate, brake;
};
constexpr std::array<Boldness, 8> kBoldness{
    {{1.0, 0.9}, {1.0, 0.6}, {0.95, 0.35}, {0.8, 0.5}, {0.6, 0.3}, {0.35, 0.2}, {0.15, 0.1}, {0.05, 0.03}}};
constexpr std::size_t kEvery = 8;  // cycles between attempts at a bolder one

/// Narrows [low, high] for x with a·x + b within [least, most].
void narrow(double a, double b, double least, double most, double& low, double& high) noexcept {
  if (a > 0) {
    low = std::max(low, (least - b) / a), high = std::min(high, (most - b) / a);
  } else if (a < 0) {
    low = std::max(low, (most - b) / a), high = std::min(high, (least - b) / a);
  }
}

/// What the plan itself uses is never too much.
double allowed(double value, double limit) noexcept {
  return std::max(kRoom * limit, std::min(std::abs(value), limit));
}

MotionLimits harder(MotionLimits l) noexcept {
  constexpr double kMore = PathOverride::kHarder;
  l.min_acceleration *= kMore, l.max_acceleration *= kMore, l.max_jerk *= kMore * kMore;
  return l;
}

}  // namespace

PathOverride::PathOverride(const TimedPath& path, std::span<const MotionLimits> limits, double period)
    : path_(path), limits_(limits), own_limits_(limits), period_(period) {
  if (limits.size() != path.joints())
    throw Error("wrong-size", "limits for " + std::to_string(limits.size()) + " joints, the path has " +
                                  std::to_string(path.joints()));
  if (!(period > 0)) throw Error("bad-limit", "the control period is " + std::to_string(period) + " s");
  for (const MotionLimits& l : limits)
    back_ = std::min({back_, -l.min_velocity / l.max_velocity, -l.max_velocity / l.min_velocity});
  for (const MotionLimits& l : limits) hard_limits_.push_back(harder(l));
  for (const SpeedProfile::Piece& p : path.profile().pieces()) jumps_.push_back(p.begin);
  for (const double s : path.path().breaks()) jumps_.push_back(path.profile().time_at(s));
  std::sort(jumps_.begin(), jumps_.end());
  for (auto* v : {&position_, &velocity_, &acceleration_, &jerk_}) v->resize(limits.size());
}

void PathOverride::look(double time) noexcept {
  path_.sample(time, position_, velocity_, acceleration_, jerk_, hint_);
}

PathOverride::Room PathOverride::room(const State& s) noexcept {
  Room out{-kMostRate, kMostRate, -kMostBend, kMostBend, -kMostRate, kMostRate};
  look(s.time);
  double square = s.factor * s.factor, cube = square * s.factor;
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    const MotionLimits& l = limits_[j];
    const double a = acceleration_[j] * square, own = jerk_[j] * cube;
    const double jerk = own + acceleration_[j] * 3 * s.factor * s.rate;
    narrow(velocity_[j], a, std::min(kRoom * l.min_acceleration, std::max(a, l.min_acceleration)),
           std::max(kRoom * l.max_acceleration, std::min(a, l.max_acceleration)), out.rate_low,
           out.rate_high);
    const double most = allowed(jerk, l.max_jerk);
    narrow(velocity_[j], jerk, -most, most, out.bend_low, out.bend_high);
    // To speed up, f' leaves alone room for itself.
    narrow(3 * acceleration_[j] * s.factor, own, -allowed(own, l.max_jerk), allowed(own, l.max_jerk),
           out.faster_low, out.faster_high);
  }
  // The same at the end of the cycle, where f' is changed by f''.
  const double t = period_, factor = s.factor + t * s.rate;
  look(std::clamp(s.time + t * (s.factor + t * s.rate / 2), 0.0, path_.duration()));
  square = factor * factor, cube = square * factor;
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    const MotionLimits& l = limits_[j];
    const double a = acceleration_[j] * square + velocity_[j] * s.rate;
    const double jerk = jerk_[j] * cube + acceleration_[j] * 3 * factor * s.rate;
    narrow(velocity_[j] * t, a, std::min(kRoom * l.min_acceleration, std::max(a, l.min_acceleration)),
           std::max(kRoom * l.max_acceleration, std::min(a, l.max_acceleration)), out.bend_low,
           out.bend_high);
    const double most = allowed(jerk, l.max_jerk);
    narrow(velocity_[j] + 3 * acceleration_[j] * factor * t, jerk, -most, most, out.bend_low, out.bend_high);
  }
  return out;
}

/// Are the limits kept in this state with this f''? For the planned values last looked at.
bool PathOverride::within(const State& s, double bend) noexcept {
  const double square = s.factor * s.factor, cube = square * s.factor, turn = 3 * s.factor * s.rate;
  double over = 0;
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    const MotionLimits& l = limits_[j];
    const double v = velocity_[j] * s.factor, a = acceleration_[j] * square + velocity_[j] * s.rate;
    const double jerk = jerk_[j] * cube + acceleration_[j] * turn + velocity_[j] * bend;
    over = std::max({over, v / l.max_velocity, v / l.min_velocity, a / l.max_acceleration,
                     a / l.min_acceleration, std::abs(jerk) / l.max_jerk});
  }
  return over <= 1 + kTolerance;
}

/// f'' of the next cycle.
double PathOverride::law(const State& s, const Room& room, double target, std::size_t level) const noexcept {
  const Boldness bold = kBoldness[level];
  const double t = period_, way = target - s.factor;
  if (way == 0 && s.rate == 0) return 0;
  // Two cycles that arrive: u1 + u2 = -rate/t and rate·2t + u1·3t²/2 + u2·t²/2 = way.
  const double sum = -s.rate / t, first = (way - 2 * t * s.rate - sum * t * t / 2) / (t * t);
  if (std::abs(s.rate + first * t) * t + std::abs(way) < 1e-13) return -s.rate / t;
  const double least = room.bend_low, most = room.bend_high;
  if (first >= least && first <= most && sum - first >= least && sum - first <= most) return first;
  // As fast as there is room for f', and so that f'' can end it at the target.
  const bool up = way > 0, faster = up == (s.factor >= 0) && target != 0;
  double highest = std::max(up ? room.rate_high : -room.rate_low, 0.0);
  if (faster) highest = std::min(highest, std::max(up ? room.faster_high : -room.faster_low, 0.0));
  highest *= bold.rate;
  const double brake = bold.brake * std::max(up ? -least : most, 0.0), left = std::abs(way);
  const double now = up ? s.rate : -s.rate;
  const double inside = brake * brake * t * t / 4 + 2 * brake * (left - now * t / 2);
  const double ending = inside > 0 ? std::sqrt(inside) - brake * t / 2 : 0;
  const double want = std::min(highest, std::max(ending, 0.0));
  const double bend = ((up ? want : -want) - s.rate) / t;
  return least <= most ? std::clamp(bend, least, most) : bend;
}

/// The state after a part of a cycle.
PathOverride::State PathOverride::during(const State& s, double bend, double t) const noexcept {
  return {std::clamp(s.time + t * (s.factor + t * (s.rate / 2 + t * bend / 6)), 0.0, path_.duration()),
          s.factor + t * (s.rate + t * bend / 2), s.rate + t * bend};
}

/// Are the limits kept within the cycle: at its thirds and on both sides of where planned jerks jump?
bool PathOverride::between(const State& s, double bend) noexcept {
  for (const double part : {1.0 / 3, 2.0 / 3}) {
    const State inside = during(s, bend, part * period_);
    look(inside.time);
    if (!within(inside, bend)) return false;
  }
  const double end = during(s, bend, period_).time, low = std::min(s.time, end), high = std::max(s.time, end);
  for (auto jump = std::upper_bound(jumps_.begin(), jumps_.end(), low); jump != jumps_.end() && *jump < high;
       ++jump) {
    const State inside = during(s, bend, period_ * (*jump - s.time) / (end - s.time));
    for (const double side : {-1e-9, 1e-9}) {
      look(*jump + side);
      if (!within(inside, bend)) return false;
    }
  }
  return true;
}

PathOverride::Run PathOverride::run(State s, double target, std::size_t level, std::size_t most) noexcept {
  const double start = s.factor;
  for (std::size_t step = 0; step < most; ++step) {
    if (std::abs(target - s.factor) < 1e-12 && std::abs(s.rate) < 1e-9) return {true, s, step};
    if (s.time >= path_.duration() && s.factor >= 0) return {true, s, step};
    if (s.time <= 0 && s.factor <= 0 && target <= 0 && step > 0) return {true, s, step};
    const Room here = room(s);
    const double bend = law(s, here, target, level);
    look(s.time);
    if (here.bend_low > here.bend_high || !within(s, bend)) return {false, s, step};
    if (!between(s, bend)) return {false, s, step};
    s = during(s, bend, period_);
    look(s.time);
    if (!within(s, bend)) return {false, s, step};
    const double past =
        start < target ? s.factor - std::max(target, start) : std::min(target, start) - s.factor;
    if (past > 1e-9) return {false, s, step};
  }
  return {false, s, most};
}

void PathOverride::begin(double time, double factor) noexcept {
  state_ = {std::clamp(time, 0.0, path_.duration()), std::clamp(factor, -back_, 1.0), 0};
  target_ = wanted_ = state_.factor, bend_ = 0, settled_ = true;
}

/// Tries laws from the boldest on; a target that none reaches yet is tried again.
void PathOverride::choose() noexcept {
  const bool fresh = anew_ || wanted_ != target_;
  if (!fresh && (settled_ || ++cycles_ % kEvery != 0)) return;
  if (!fresh) level_to_try_ = 0;
  std::size_t steps = kMostSteps;
  for (std::size_t runs = 0; runs < (fresh ? kMostRuns : 1); ++runs, ++level_to_try_) {
    if (!fresh && level_to_try_ >= level_) return;
    if (level_to_try_ == kBoldness.size()) level_to_try_ = 0;
    const Run tried = run(state_, wanted_, level_to_try_, steps);
    steps -= tried.steps;
    if (!tried.safe) continue;
    target_ = wanted_, level_ = level_to_try_, settled_ = anew_ = false;
    return;
  }
}

void PathOverride::advance(double target, bool immediate) noexcept {
  const bool hard = limits_.data() != own_limits_.data(), stand = stands();
  if (immediate && !hard && !stand) {
    limits_ = hard_limits_, level_to_try_ = 0, cycles_ = 0;
    anew_ = true;  // with what there is now
  }
  if (hard && stand && !immediate) limits_ = own_limits_;
  if (!(target > -2) || limits_.data() != own_limits_.data()) target = 0;
  target = std::clamp(target, -back_, 1.0);
  if (target != wanted_) wanted_ = target, level_to_try_ = 0, cycles_ = 0;
  choose();
  if (settled_) {
    bend_ = 0;
    state_ = during(state_, 0, period_);
    return;
  }
  bend_ = law(state_, room(state_), target_, level_);
  state_ = during(state_, bend_, period_);
  if (std::abs(target_ - state_.factor) < 1e-12 && std::abs(state_.rate) < 1e-9) {
    state_.factor = target_, state_.rate = 0, settled_ = true;
  }
}

void PathOverride::sample(std::span<double> position, std::span<double> velocity,
                          std::span<double> acceleration) noexcept {
  look(state_.time);
  std::copy_n(position_.begin(), position.size(), position.begin());
  for (std::size_t j = 0; j < velocity.size(); ++j) velocity[j] = velocity_[j] * state_.factor;
  for (std::size_t j = 0; j < acceleration.size(); ++j)
    acceleration[j] = acceleration_[j] * state_.factor * state_.factor + velocity_[j] * state_.rate;
}

StoppingWay PathOverride::stopping() noexcept {
  std::size_t hint = 0;
  for (std::size_t level = 0; level < kBoldness.size(); ++level) {
    const Run end = run(state_, 0, level, kMostSteps);
    if (!end.safe) continue;
    return {double(end.steps) * period_,
            path_.profile().at(end.end.time, hint).s - path_.profile().at(state_.time, hint).s, true};
  }
  return {0, 0, false};
}

}  // namespace polyarm::trajectory
