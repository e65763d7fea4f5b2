#include "polyarm/jog/body_guard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace polyarm::jog {

using surroundings::GuardPair;

namespace {
/// Links of one robot may come this near to each other, m; held parts and what they lie on may overlap by
/// kPressing.
constexpr double kOwn = 0.001, kPressing = 0.002;
/// Barriers reach this far beyond what the joints can move, m: the robot moves on while the cell thread is
/// late. Bodies of one robot are few and near each other; what has no barrier counts with the levers of the
/// whole robot and slows every jog, so they have barriers from farther.
constexpr double kBeyond = 0.05, kBeyondOwn = 0.15;
/// Deeper than this it counts as a contact, m.
constexpr double kContact = 5e-4;
/// A robot that is too near already may come nearer by this; steps along the way on which it brakes, m.
constexpr double kDeeper = 2e-4, kStep = 5e-4;
/// The least room of what has no barrier of its own because nearer places have them all, m: those keep the
/// robot from going deeper, and it can leave, as JogGenerator lets it go a little below this.
constexpr double kLeastRest = -2e-4;
/// Reaction to new barriers: some ticks and cycles, s.
constexpr double kReaction = 0.01;
}  // namespace

double stopping_reach(double velocity, const AxisLimits& limits) noexcept {
  const double v = std::abs(velocity) + kReaction * limits.acceleration;
  return v * v / limits.acceleration + v * (limits.acceleration / limits.jerk + kReaction);
}

BodyGuard::BodyGuard(surroundings::GuardBodies& bodies, int robot, std::vector<AxisLimits> limits,
                     const BodyGuardOptions& options)
    : bodies_(bodies), robot_(robot), limits_(std::move(limits)), options_(options) {
  reach_.assign(limits_.size(), 0);
  trial_.assign(limits_.size(), 0);
  reaches_.assign(bodies.bodies(), 0);
}

double BodyGuard::margin(const GuardPair& pair) const noexcept {
  using Kind = surroundings::BodyKind;
  if (pair.own) return pair.of_part ? 0 : kOwn;
  if (pair.of_zone) return 0;
  if (pair.other_than(robot_) >= 0) return options_.clearance;
  const std::uint32_t body = pair.robot_a == robot_ ? pair.a : pair.b;
  if (bodies_.kind(body) == Kind::part) return -kPressing;
  if (bodies_.is_hand(body)) return std::min(options_.tool_clearance, options_.clearance);
  return options_.clearance;
}

/// The room of a pair in terms of the levers of the whole robot: a link near the base moves little.
double BodyGuard::room_in_levers(double room, const GuardPair& pair, const Barriers& out) noexcept {
  if (room <= 0) return room;
  double share = std::numeric_limits<double>::infinity();
  const std::span<const double> lever = bodies_.lever_of(pair, robot_);
  for (std::size_t j = 0; j < lever.size(); ++j)
    if (lever[j] > 0) share = std::min(share, out.lever[j] / lever[j]);
  return room * share;
}

void BodyGuard::keep_rest(double room, std::size_t pair, Barriers& out) noexcept {
  if (room >= out.rest) return;
  room = room_in_levers(room, bodies_.pairs()[pair], out);
  if (room >= out.rest) return;
  out.rest = room;
  out.rest_which = static_cast<std::int32_t>(pair);
}

/// Keeps those with the least room.
void BodyGuard::add(const Barrier& barrier, Barriers& out) noexcept {
  if (out.count < Barriers::kMost) {
    out.all[out.count++] = barrier;
    return;
  }
  const auto roomiest = std::max_element(out.all.begin(), out.all.end(),
                                         [](const Barrier& x, const Barrier& y) { return x.room < y.room; });
  Barrier dropped = barrier;
  if (barrier.room < roomiest->room) std::swap(*roomiest, dropped);
  keep_rest(std::max(dropped.room, kLeastRest), static_cast<std::size_t>(dropped.which), out);
}

/// True if the body of the robot goes nearly where the TCP goes while the tool keeps its orientation: the
/// hand, a held part and the wrist.
bool BodyGuard::moves_with_tcp(const GuardPair& pair) const noexcept {
  if (pair.own) return false;
  const std::uint32_t mine = pair.robot_a == robot_ ? pair.a : pair.b;
  if (bodies_.is_hand(mine) || bodies_.kind(mine) == surroundings::BodyKind::part) return true;
  const std::span<const double> lever = bodies_.lever_of(pair, robot_);
  const auto moving = std::count_if(lever.begin(), lever.end(), [](double by) { return by > 0; });
  const auto all = static_cast<std::ptrdiff_t>(limits_.size());
  return moving >= all - (all >= 6 ? 2 : 1);
}

void BodyGuard::add_points(std::size_t index, double keep, std::size_t count, Barriers& out) noexcept {
  const GuardPair& pair = bodies_.pairs()[index];
  Barrier barrier;
  barrier.which = static_cast<std::int32_t>(index);
  barrier.slides = moves_with_tcp(pair);
  const std::span<const double> levers = bodies_.lever_of(pair, robot_);
  barrier.moving.reset();
  for (std::size_t j = 0; j < levers.size(); ++j) {
    barrier.bend = std::max(barrier.bend, levers[j]);
    barrier.moving[j] = levers[j] > 0;
  }
  for (std::size_t i = 0; i < count; ++i) {
    barrier.room = points_[i].distance - keep;
    bodies_.gradient(pair, robot_, points_[i], {barrier.gradient.data(), limits_.size()});
    add(barrier, out);
  }
}

void BodyGuard::fill(std::span<const double> velocity, std::span<const std::vector<double>> stopping,
                     Barriers& out) noexcept {
  const std::span<const double> q = bodies_.joints(static_cast<std::size_t>(robot_));
  out.touching = false;
  out.count = 0;
  out.rest = std::numeric_limits<double>::infinity();
  out.rest_which = -1;
  std::copy(q.begin(), q.end(), out.at.begin());
  bodies_.levers(robot_, {out.lever.data(), limits_.size()});
  for (std::size_t j = 0; j < limits_.size(); ++j) reach_[j] = stopping_reach(velocity[j], limits_[j]);
  bodies_.reaches(robot_, reach_, stopping, reaches_);
  const std::uint64_t budget = bodies_.measured() + options_.most_measured;
  // Pairs for which there was no time are the first ones of the next tick.
  const std::size_t pairs = bodies_.pairs().size(), first_pair = std::exchange(first_pair_, 0);
  bool waits = false;
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::size_t i = (first_pair + k) % pairs;
    const GuardPair& pair = bodies_.pairs()[i];
    if (!pair.active || !pair.concerns(robot_)) continue;
    const int other = pair.own ? -1 : pair.other_than(robot_);
    const bool first = pair.robot_a == robot_;
    const std::uint32_t mine = first ? pair.a : pair.b, its = first ? pair.b : pair.a;
    const double drift = other < 0 ? 0 : reaches_[its];
    const double least = margin(pair), keep = least + drift;
    const double range =
        keep + (pair.own ? bodies_.change(pair, robot_, reach_) + kBeyondOwn : reaches_[mine] + kBeyond);
    // What was never measured has no bound, and would hold nothing back.
    const bool is_unknown = !std::isfinite(pair.slack);
    const bool is_near = pair.slack <= range,
               measures = is_near && (bodies_.measured() < budget || is_unknown);
    if (is_near && !measures && !std::exchange(waits, true)) first_pair_ = i;
    double left_out = std::numeric_limits<double>::infinity();
    const std::size_t count = measures ? bodies_.measure_points(i, robot_, range, points_, left_out) : 0;
    if (count == 0) {
      keep_rest(pair.slack - keep, i, out);
      continue;
    }
    if (pair.slack < -kContact && pair.slack < least) out.touching = true;
    add_points(i, keep, count, out);
    if (std::isfinite(left_out)) keep_rest(std::max(left_out - keep, kLeastRest), i, out);
  }
}

/// Steps along the way that are proven: what is farther than a step cannot be reached by it.
bool BodyGuard::follow(std::size_t index, std::span<const double> way, double least, double reach,
                       InTheWay& out) noexcept {
  const GuardPair& pair = bodies_.pairs()[index];
  const std::span<const double> q = bodies_.joints(static_cast<std::size_t>(robot_));
  for (double share = 0;;) {
    for (std::size_t j = 0; j < trial_.size(); ++j) trial_[j] = q[j] + share * way[j];
    bodies_.try_joints(static_cast<std::size_t>(robot_), trial_);
    const surroundings::GuardGap gap = bodies_.gap_of(pair, least + reach, robot_);
    if (share == 0) least = std::min(least, gap.distance - kDeeper);
    if (gap.distance < least) {
      out = {static_cast<std::int32_t>(index), gap, least};
      return true;
    }
    if (share >= 1) return false;
    share = std::min(1.0, share + std::max(gap.distance - least, kStep) / reach);
  }
}

BodyGuard::InTheWay BodyGuard::in_the_way(std::span<const double> way,
                                          std::span<const std::vector<double>> stopping) noexcept {
  InTheWay out;
  for (std::size_t j = 0; j < reach_.size(); ++j) reach_[j] = std::abs(way[j]);
  bodies_.reaches(robot_, reach_, stopping, reaches_);
  const std::uint64_t budget = bodies_.measured() + options_.most_measured;
  for (std::size_t i = 0; i < bodies_.pairs().size() && bodies_.measured() < budget; ++i) {
    const GuardPair& pair = bodies_.pairs()[i];
    if (!pair.active || !pair.concerns(robot_)) continue;
    const bool first = pair.robot_a == robot_, meets = !pair.own && pair.other_than(robot_) >= 0;
    const double drift = meets ? reaches_[first ? pair.b : pair.a] : 0;
    const double reach = pair.own ? bodies_.change(pair, robot_, reach_) : reaches_[first ? pair.a : pair.b];
    // Nobody says where the motion ends: it may be meant to end near something.
    const double keep = meets ? margin(pair) : std::min(margin(pair), options_.tool_clearance);
    const double needed = keep + drift + reach;
    if (reach <= 0 || pair.slack >= needed || bodies_.measure(i, needed) >= needed) continue;
    if (follow(i, way, keep + drift, reach, out)) return out;
  }
  return out;
}

}  // namespace polyarm::jog
