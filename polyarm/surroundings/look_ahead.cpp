#include "polyarm/surroundings/look_ahead.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::surroundings {

namespace {
constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr std::size_t kSamples = 8;  // of the way, for the bound on how far the joints go
constexpr double kTouching = 3e-4;   // m that a pair may come nearer than it was at the start
constexpr double kRounding = 2e-4;   // m below the required distance that do not count
constexpr double kNear = 0.01;       // m of room with which the steps along the way are long enough
constexpr double kStill = 1e-4;      // m that an obstacle may move before its way is looked at again
// s that near pairs are followed further, so that the next looks know them; not all equally far, so that they
// are not followed again all at once.
constexpr double kFurther = 0.25;
constexpr std::size_t kSpread = 16;
/// A part may lie this much nearer to something than planned, m: grips and movers are not exact.
constexpr double kInexact = 0.003;
constexpr std::uint64_t kAtFirst = 5;  // the first look along a way may measure so many times as much
}  // namespace

LookAhead::LookAhead(GuardBodies& bodies, int robot, const LookAheadOptions& options)
    : bodies_(bodies), robot_(robot), options_(options) {
  for (std::size_t i = 0; i < bodies.pairs().size(); ++i)
    if (bodies.pairs()[i].of_part || bodies.pairs()[i].concerns(robot)) pairs_.push_back(i);
  of_.resize(pairs_.size());
  const std::size_t n = bodies.variables(static_cast<std::size_t>(robot));
  for (std::vector<double>* values : {&q_, &v_, &from_, &way_, &step_}) values->assign(n, 0);
  ends_.reserve(kMostEnds + 2);
  touches_.reserve(kMostEnds);
  mine_.reserve(of_.size());
}

void LookAhead::begin(PlannedWay& way, std::span<const double> ends,
                      std::span<const TouchTime> touches) noexcept {
  is_first_ = true;
  touches_.assign(touches.begin(), touches.begin() + static_cast<std::ptrdiff_t>(std::min(touches.size(), kMostEnds)));
  ends_.assign(1, 0.0);
  for (std::size_t i = 0; i < ends.size() && i < kMostEnds; ++i) ends_.push_back(ends[i]);
  ends_.push_back(way.duration());
  for (Of& of : of_) {
    of.required = kForever;
    of.clear_until = -1;
  }
  for (const double time : ends_) {
    way.at(time, q_, v_);
    bodies_.try_joints(static_cast<std::size_t>(robot_), q_);
    for (std::size_t i = 0; i < of_.size(); ++i) require(i, way, {&time, 1});
  }
  for (std::size_t i = 0; i < of_.size(); ++i) of_[i].version = pair_at(i).version;
}

/// Lowers what is required of a pair to what it has at an end of a move, where try_joints() put the robot.
void LookAhead::require(std::size_t i, PlannedWay&, std::span<const double> times) noexcept {
  const GuardPair& pair = pair_at(i);
  Of& of = of_[i];
  if (!pair.active || !pair.concerns(robot_)) return;
  const double most = pair.own || pair.of_zone ? 0 : options_.clearance;
  of.required = std::min(of.required, most);
  const bool held = is_held(pair);
  const double near = held ? most + kInexact : most;
  const double distance = bodies_.gap_of(pair, near, robot_).distance;
  if (distance >= near) return;
  const bool starts = times.front() == 0;
  double least = distance > 0 ? options_.share * distance : distance - kTouching;
  if (held) least = std::min(least, -kPressing);  // it is taken from there, or put there
  // A goal inside something is no reason to go there; a start inside something is one to leave it.
  const double floor = pair.of_part ? -kPressing : 0;
  of.required = std::min(of.required, starts ? least : std::max(least, floor));
}

/// After a part was taken or brought: as if the way began here.
void LookAhead::renew(std::size_t i, PlannedWay& way) noexcept {
  of_[i] = {kForever, -1, 0, pair_at(i).version};
  for (const double time : ends_) {
    way.at(time, q_, v_);
    bodies_.try_joints(static_cast<std::size_t>(robot_), q_);
    require(i, way, {&time, 1});
  }
}

/// How far the other body of a pair may still come.
double LookAhead::drift(const GuardPair& pair, std::span<const std::vector<double>> stopping) const noexcept {
  const int other = pair.own ? -1 : pair.other_than(robot_);
  return other < 0 ? 0 : bodies_.change(pair, other, stopping[static_cast<std::size_t>(other)]);
}

LookAhead::Answer LookAhead::look(PlannedWay& way, double now, double until,
                                  std::span<const std::vector<double>> stopping) noexcept {
  const std::size_t n = q_.size();
  const std::span<const double> acceleration = way.acceleration();
  until = std::min(until, way.duration());
  budget_ = bodies_.measured() + options_.most_measured * (is_first_ ? kAtFirst : 1);
  is_first_ = false;
  // How far the joints go from here, at most.
  way.at(now, from_, v_);
  std::fill(way_.begin(), way_.end(), 0.0);
  const double h = std::max(0.0, until - now) / kSamples;
  std::fill(step_.begin(), step_.end(), 0.0);
  for (std::size_t k = 1; k <= kSamples; ++k) {
    way.at(now + h * static_cast<double>(k), q_, v_);
    for (std::size_t j = 0; j < n; ++j)
      way_[j] = std::max(way_[j], std::abs(q_[j] - from_[j]) + acceleration[j] * h * h / 8);
    for (std::size_t j = 0; j < n; ++j) step_[j] = std::max(step_[j], std::abs(v_[j]));
  }
  speed_ = bodies_.fastest(robot_, step_);
  Answer out;
  out.free_until = kForever;
  mine_.clear();
  for (std::size_t i = 0; i < of_.size(); ++i) {
    const GuardPair& pair = pair_at(i);
    if (!pair.active || !pair.concerns(robot_) || looked_until(pair, now, until) <= now) continue;
    const double most = pair.own || pair.of_zone ? 0 : options_.clearance;
    const double needed = most + bodies_.change(pair, robot_, way_) + drift(pair, stopping);
    if (pair.slack >= needed || is_known(i, until)) continue;
    const bool is_followed = is_still(i) && of_[i].clear_until > now;
    if (is_followed || bodies_.measure(pairs_[i], needed) < needed) mine_.push_back(i);
  }
  for (const std::size_t i : mine_) {
    const GuardPair& pair = pair_at(i);
    if (of_[i].version != pair.version) renew(i, way);
    const double further = kFurther * (1 + static_cast<double>(i % kSpread) / kSpread);
    const double end =
        looked_until(pair, now, is_still(i) ? std::min(until + further, way.duration()) : until);
    scan(i, way, now, std::min(end, out.free_until), drift(pair, stopping), out);
  }
  return out;
}

/// True if the pair was followed that far already, and what is around has not moved since.
bool LookAhead::is_known(std::size_t i, double until) const noexcept {
  return is_still(i) && of_[i].version == pair_at(i).version && of_[i].clear_until >= until;
}

bool LookAhead::is_still(std::size_t i) const noexcept {
  const GuardPair& pair = pair_at(i);
  if (pair.own) return true;
  return pair.other_than(robot_) < 0 && bodies_.moved(obstacle_of(pair)) - of_[i].moved <= kStill;
}

/// A part that the robot holds, with something that no robot moves.
bool LookAhead::is_held(const GuardPair& pair) const noexcept {
  if (!pair.of_part || pair.own || pair.of_zone || pair.other_than(robot_) >= 0) return false;
  return bodies_.kind(pair.robot_a == robot_ ? pair.a : pair.b) == BodyKind::part;
}

/// The tool, its fingers, or a part that the robot holds, with something that no robot moves.
bool LookAhead::may_touch(const GuardPair& pair) const noexcept {
  if (pair.own || pair.of_zone || pair.other_than(robot_) >= 0) return false;
  const BodyKind kind = bodies_.kind(pair.robot_a == robot_ ? pair.a : pair.b);
  return kind == BodyKind::tool || kind == BodyKind::fingers || kind == BodyKind::part;
}

/// Until when a pair must be clear: a contact that is meant is not looked for.
double LookAhead::looked_until(const GuardPair& pair, double now, double until) const noexcept {
  if (touches_.empty() || !may_touch(pair)) return until;
  for (const TouchTime& touch : touches_)
    if (now <= touch.to) return touch.from <= now ? now : std::min(until, touch.from);
  return until;
}

/// Follows a near pair along the way; true if it is clear until then.
bool LookAhead::scan(std::size_t i, PlannedWay& way, double now, double until, double drift,
                     Answer& out) noexcept {
  const GuardPair& pair = pair_at(i);
  Of& of = of_[i];
  if (!is_still(i)) {
    if (is_held(pair)) renew(i, way);  // the place to which the part goes may have moved
    of.clear_until = -1;
    if (!pair.own && pair.other_than(robot_) < 0) of.moved = bodies_.moved(obstacle_of(pair));
  }
  double time = std::max(now, of.clear_until);
  const std::span<const double> acceleration = way.acceleration();
  while (time < until) {
    if (bodies_.measured() >= budget_) {  // the rest is not known: as if something were there
      out.free_until = time;
      out.pair = -1;
      return false;
    }
    way.at(time, q_, v_);
    bodies_.try_joints(static_cast<std::size_t>(robot_), q_);
    const GuardGap gap = bodies_.gap_while_braking(pair, robot_, drift, of.required + kNear);
    const double room = gap.distance - of.required;
    if (room < -kRounding) {
      out = {time, static_cast<int>(pairs_[i]), gap, of.required};
      return false;
    }
    for (std::size_t j = 0; j < q_.size(); ++j) step_[j] = std::abs(v_[j]);
    const double rate = bodies_.change(pair, robot_, step_),
                 bend = bodies_.change(pair, robot_, acceleration);
    const double m = std::max(room, kResolution);
    time += bend > 1e-12   ? (std::sqrt(rate * rate + 2 * bend * m) - rate) / bend
            : rate > 1e-12 ? m / rate
                           : until - now;
    of.clear_until = time;
  }
  return true;
}

}  // namespace polyarm::surroundings
