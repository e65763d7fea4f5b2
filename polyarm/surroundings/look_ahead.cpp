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
constexpr std::uint64_t kFurtherMeasured = 16;  // exact distances in one look for that
constexpr double kEager = 0.02;                 // m
/// A part may lie this much nearer to something than planned, m: grips and movers are not exact.
constexpr double kInexact = 0.003;
}  // namespace

LookAhead::LookAhead(GuardBodies& bodies, int robot, const LookAheadOptions& options)
    : bodies_(bodies), robot_(robot), options_(options) {
  for (std::size_t i = 0; i < bodies.pairs().size(); ++i)
    if (bodies.pairs()[i].of_part || bodies.pairs()[i].concerns(robot)) pairs_.push_back(i);
  of_.resize(pairs_.size());
  const std::size_t n = bodies.variables(static_cast<std::size_t>(robot));
  for (std::vector<double>* values : {&q_, &v_, &from_, &way_, &step_}) values->assign(n, 0);
  reaches_.assign(bodies.bodies(), 0);
  ends_.reserve(kMostEnds + 2);
  end_frames_.assign(kMostEnds + 2, std::vector<Pose>(bodies.frames(static_cast<std::size_t>(robot))));
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
  for (std::size_t k = 0; k < ends_.size(); ++k) {
    way.at(ends_[k], q_, v_);
    bodies_.frames_at(static_cast<std::size_t>(robot_), q_, end_frames_[k]);
  }
  for (std::size_t i = 0; i < of_.size(); ++i) {
    of_[i].is_required = false;
    of_[i].clear_until = -1;
    of_[i].version = pair_at(i).version;
    if (may_change(pair_at(i))) require(i);
  }
}

/// True if the distance of a pair at an end of the way is another one later.
bool LookAhead::may_change(const GuardPair& pair) const noexcept {
  if (pair.of_part) return true;
  return !pair.own && (pair.other_than(robot_) >= 0 || !bodies_.is_static(obstacle_of(pair)));
}

/// What is required of a pair: less than the clearance if the pair has less at an end of a move.
void LookAhead::require(std::size_t i) noexcept {
  const GuardPair& pair = pair_at(i);
  Of& of = of_[i];
  of.required = kForever;
  of.is_required = true;
  if (!pair.active || !pair.concerns(robot_)) return;
  for (std::size_t k = 0; k < ends_.size(); ++k) require_at(k, pair, of);
}

void LookAhead::require_at(std::size_t end, const GuardPair& pair, Of& of) noexcept {
  bodies_.try_frames(end_frames_[end]);
  const double most = pair.own || pair.of_zone ? 0 : options_.clearance;
  of.required = std::min(of.required, most);
  const bool held = is_held(pair);
  const double near = held ? most + kInexact : most;
  const double distance = bodies_.gap_of(pair, near, robot_).distance;
  if (distance >= near) return;
  double least = distance > 0 ? options_.share * distance : distance - kTouching;
  if (held) least = std::min(least, -kPressing);  // it is taken from there, or put there
  // A goal inside something is no reason to go there; a start inside something is one to leave it.
  const double floor = pair.of_part ? -kPressing : 0;
  of.required = std::min(of.required, ends_[end] == 0 ? least : std::max(least, floor));
}

/// How far the other body of a pair may still come.
double LookAhead::drift(const GuardPair& pair) const noexcept {
  const int other = pair.own ? -1 : pair.other_than(robot_);
  return other < 0 ? 0 : reaches_[obstacle_of(pair)];
}

/// How far the joints go from here until then, at most, and how fast the robot moves.
void LookAhead::find_reaches(PlannedWay& way, double now, double until,
                             std::span<const std::vector<double>> stopping) noexcept {
  const std::size_t n = q_.size();
  const std::span<const double> acceleration = way.acceleration();
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
  bodies_.reaches(robot_, way_, stopping, reaches_);
}

LookAhead::Answer LookAhead::look(PlannedWay& way, double now, double until,
                                  std::span<const std::vector<double>> stopping) noexcept {
  until = std::min(until, way.duration());
  find_reaches(way, now, until, stopping);
  Answer out;
  out.free_until = kForever;
  mine_.clear();
  for (std::size_t i = 0; i < of_.size(); ++i) {
    const GuardPair& pair = pair_at(i);
    if (!pair.active || !pair.concerns(robot_) || looked_until(pair, now, until) <= now) continue;
    const double most = pair.own || pair.of_zone ? 0 : options_.clearance;
    const double needed =
        most + (pair.own ? bodies_.change(pair, robot_, way_) : reaches_[pair.a] + reaches_[pair.b]);
    if (pair.slack >= needed || is_known(i, until)) continue;
    // What stands only a little farther is followed, too: else its distance is measured again and again.
    const bool still = is_still(i), is_followed = still && of_[i].clear_until > now;
    const double near = still ? needed + kEager : needed;
    if (is_followed || distance_of(i, near) < near) mine_.push_back(i);
  }
  budget_ = bodies_.measured() + options_.most_measured * (is_first_ ? options_.at_first : 1);
  is_first_ = false;
  for (const std::size_t i : mine_) {
    const GuardPair& pair = pair_at(i);
    if (of_[i].version != pair.version) {  // a part was taken or brought: as if the way began here
      of_[i].clear_until = -1, of_[i].moved = 0, of_[i].version = pair.version;
      of_[i].is_required = false;
    }
    if (!of_[i].is_required) {
      const std::uint64_t had = bodies_.measured();
      require(i);
      budget_ += bodies_.measured() - had;
    }
    scan(i, way, now, std::min(looked_until(pair, now, until), out.free_until), out);
  }
  follow_further(way, now, until);
  return out;
}

/// The distance of a pair, at least `enough` if it is farther. What has not moved is not measured again.
double LookAhead::distance_of(std::size_t i, double enough) noexcept {
  Of& of = of_[i];
  const GuardPair& pair = pair_at(i);
  if (of.seen != pair.slack || of.seen >= enough || of.version != pair.version)
    of.seen = bodies_.measure(pairs_[i], enough);
  return of.seen;
}

/// Follows near pairs beyond this look, a little in each, so that the next ones know them.
void LookAhead::follow_further(PlannedWay& way, double now, double until) noexcept {
  budget_ = std::min(budget_, bodies_.measured() + kFurtherMeasured);
  Answer ignored;
  for (const std::size_t i : mine_) {
    if (bodies_.measured() >= budget_) return;
    if (!is_still(i) || of_[i].clear_until < until) continue;
    const double further = kFurther * (1 + static_cast<double>(i % kSpread) / kSpread);
    scan(i, way, now, looked_until(pair_at(i), now, std::min(until + further, way.duration())), ignored);
  }
}

/// True if the pair was followed that far already, and what is around has not moved since.
bool LookAhead::is_known(std::size_t i, double until) const noexcept {
  return is_still(i) && of_[i].version == pair_at(i).version && of_[i].clear_until >= until;
}

bool LookAhead::is_still(std::size_t i) const noexcept {
  const GuardPair& pair = pair_at(i);
  if (pair.own) return true;
  return bodies_.moved(obstacle_of(pair)) - of_[i].moved <= kStill && drift(pair) == of_[i].drift;
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
bool LookAhead::scan(std::size_t i, PlannedWay& way, double now, double until, Answer& out) noexcept {
  const GuardPair& pair = pair_at(i);
  Of& of = of_[i];
  if (!is_still(i)) {
    if (is_held(pair)) require(i);  // the place to which the part goes may have moved
    of.clear_until = -1;
    if (!pair.own) of.moved = bodies_.moved(obstacle_of(pair)), of.drift = drift(pair);
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
    const GuardGap gap = bodies_.gap_while_braking(pair, robot_, drift(pair), of.required + kNear);
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
