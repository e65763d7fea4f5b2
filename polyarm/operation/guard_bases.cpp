/// Guards of bases that drive: a base slows down and stops before it, or what it carries, touches something.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "polyarm/operation/guard_work.hpp"
#include "polyarm/surroundings/base_ways.hpp"

namespace polyarm::cell {

using surroundings::GuardGap;
using surroundings::GuardPair;

namespace {
/// Before a base begins to brake, s: while somebody drives it by keys, and when the cell is held.
constexpr double kLatencyOfKeys = 0.15, kLatencyOfHold = 0.08;
/// Odometry comes less often than ticks: its velocity is taken over this time, and it stands when nothing has
/// come for the second one, ns.
constexpr Nanoseconds kBetween = 40'000'000, kSilentBase = 100'000'000;
/// Somebody who drives a base asks again within this time, ns.
constexpr Nanoseconds kDriverAsks = 300'000'000;
/// A smaller share of what is asked does not move it.
constexpr double kLeastShare = 0.02;
/// Slower than this a base stands, m/s and rad/s; below kClosesIn it does not come nearer, m/s.
constexpr double kBaseStands = 2e-3, kClosesIn = 2e-3;
/// No point of a base and of what it carries is farther from its middle, m.
constexpr double kFarthestPoint = 3;
/// A base that is nearer than the clearance may come so much nearer on the way that was planned: a part of
/// the distance, and at least so many m, but half of the distance always stays.
constexpr double kNearer = 0.2, kLeastNearer = 2e-3;
/// A way is looked at in steps of at least this length, m.
constexpr double kStepOfWay = 5e-3;
/// Where a controller states no deceleration, m/s².
constexpr double kDeceleration = 1;

/// The distance to keep on a way that was planned, with this distance now. A base in contact may leave it.
double kept_on_way(double distance, double clearance) {
  const double least = distance > 0 ? std::min(kLeastNearer, distance / 2) : kLeastNearer;
  return std::min(clearance, distance - std::max(kNearer * distance, least));
}
}  // namespace

/// What is nearest in the way of a base.
struct Guards::NearBase {
  double share = 1;  ///< of the velocity with which it can still stop in time
  int pair = -1;
  std::uint32_t other = 0;  ///< the body of it that the base does not carry
  GuardGap gap;
};

/// Where a base goes and how it comes to rest.
struct Guards::BaseWay {
  double braking = kDeceleration;                    ///< m/s²
  double latency = 0;                                ///< s, before it brakes
  std::optional<moves::BaseMotion::Left> left = {};  ///< of a move that ends by itself; nothing: it drives on
  Pose T_world_base = {};                            ///< with `left`: of the frame that its wheels move

  bool is_known() const { return left && left->way > 0; }
  /// The highest speed with which it comes to rest within this length.
  double speed_before(double room) const {
    return braking * (std::sqrt(latency * latency + 2 * room / braking) - latency);
  }
  /// How far it drives on its line or arc until a body of it, `a` or else `b` of the pair, is nearer than
  /// `keep` to the other one; at most `most`. `gap`: now, and then there.
  double free(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, double keep, double most,
              GuardGap& gap) const;

 private:
  Pose after(double driven) const;
};

/// The motion in the world until it has driven so far along its line or arc.
Pose Guards::BaseWay::after(double driven) const {
  const Vec3 ahead = T_world_base.rotation * Vec3{1, 0, 0};
  const surroundings::BasePlace now{T_world_base.position.x, T_world_base.position.y,
                                    std::atan2(ahead.y, ahead.x)};
  const surroundings::BasePlace then =
      surroundings::along(now, left->curvature, left->backwards ? -driven : driven);
  const auto pose = [](const surroundings::BasePlace& at) {
    return Pose{{at.x, at.y, 0}, from_rpy(0, 0, at.heading)};
  };
  return pose(then) * inverse(pose(now));
}

double Guards::BaseWay::free(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, double keep,
                             double most, GuardGap& gap) const {
  const double lever = 1 + std::abs(left->curvature) * kFarthestPoint;
  double driven = 0, proven = 0;  // the distances are enough as far as `proven`
  while (gap.distance >= keep) {
    if (driven >= most) return most;
    proven = driven + (gap.distance - keep) / lever;
    driven = std::min(most, std::max(proven, driven + kStepOfWay));
    gap = bodies.gap_after(pair, a, after(driven), keep + lever * (most - driven));
  }
  return proven;
}

/// Sees how a base moves. Says once that nothing guards the arm on a base that drives.
void Guards::see_base(std::size_t r) {
  Of& of = work_->robots[r];
  constexpr double kMoved = 2e-3;  // m, rad
  const Pose& base = work_->moment.robots[r].base;
  const Nanoseconds now = cell_.machine.now();
  if (!of.base) of.base = of.base_before = of.base_seen = base;
  const bool changed = !(of.base_seen == base);
  of.base_seen = base;
  if (changed) of.base_changed = now;
  const bool silent = now - of.base_changed > kSilentBase;
  if (silent || (changed && now - of.base_since >= kBetween)) {
    const double dt = seconds(now - of.base_since);
    of.base_velocity = silent ? Vec3{} : (1 / dt) * (base.position - of.base_before.position);
    of.base_turning =
        silent ? 0 : to_rotation_vector(base.rotation * inverse(of.base_before.rotation)).z / dt;
    of.base_before = base;
    of.base_since = now;
  }
  if (of.drove || !cell_.setup.robots[r]->entry.on.empty()) return;
  if (norm(base.position - of.base->position) < kMoved &&
      angle_between(base.rotation, of.base->rotation) < kMoved)
    return;
  of.drove = true;
  const bool guarded = cell_.motions.wheels(r) && cell_.setup.file.guards.bases;
  const std::string& name = cell_.setup.robots[r]->entry.name;
  cell_.observer.on_note(
      guarded ? name + " drives: guards stop its base before contacts, and do not watch its arm"
              : name + " drives: guards do not watch a base that moves by itself");
}

/// True while a base with wheels moves, or somebody drives it by keys.
bool Guards::base_drives(std::size_t r) const {
  const Of& of = work_->robots[r];
  if (!cell_.setup.file.guards.bases || !cell_.motions.wheels(r)) return false;
  const bool is_asked = of.base_asked >= 0 && cell_.machine.now() - of.base_asked < kDriverAsks;
  return is_asked || norm(of.base_velocity) > kBaseStands || std::abs(of.base_turning) > kBaseStands;
}

double Guards::braking_of_base(std::size_t r) const {
  const controllers::SpeedLimits limits = cell_.motions.wheels(r)->controller().linear_limits();
  for (const double limit : {limits.max_deceleration, limits.max_acceleration})
    if (std::isfinite(limit) && limit != 0) return std::abs(limit);
  return kDeceleration;
}

/// `velocity`: of the base in the world, `turning`: about the vertical.
Guards::NearBase Guards::near_base(std::size_t r, const Vec3& velocity, double turning,
                                   const BaseWay& way) const {
  NearBase out;
  surroundings::GuardBodies& bodies = *work_->bodies;
  const Vec3 middle = work_->moment.robots[r].base.position;
  const auto is_carried = [&](int robot) {
    for (std::size_t steps = 0; robot >= 0 && steps < work_->robots.size(); ++steps) {
      if (robot == static_cast<int>(r)) return true;
      const std::string& on = cell_.setup.robots[static_cast<std::size_t>(robot)]->entry.on;
      robot = -1;
      for (std::size_t k = 0; k < work_->robots.size() && !on.empty(); ++k)
        if (cell_.setup.robots[k]->entry.name == on) robot = static_cast<int>(k);
    }
    return false;
  };
  using Kind = surroundings::BodyKind;
  const double fastest = norm(velocity) + std::abs(turning) * kFarthestPoint;
  const double clearance = cell_.setup.file.guards.clearance;
  const double within = clearance + fastest * fastest / (2 * way.braking) + fastest * way.latency;
  for (std::size_t i = 0; i < bodies.pairs().size(); ++i) {
    const GuardPair& pair = bodies.pairs()[i];
    if (!pair.active || pair.own || pair.of_part || pair.slack >= within) continue;
    const bool a = is_carried(pair.robot_a), b = is_carried(pair.robot_b);
    if (a == b || bodies.kind(a ? pair.b : pair.a) == Kind::floor) continue;
    GuardGap gap = bodies.gap_of(pair, within);
    if (gap.distance >= within) continue;
    if (way.is_known()) {
      const double speed = norm(velocity);
      const double most = std::min(way.left->way, speed * (way.latency + speed / (2 * way.braking)));
      const double keep = kept_on_way(gap.distance, clearance);
      const double free = way.free(bodies, pair, a, keep, most, gap);
      if (free >= most) continue;
      const double share = way.speed_before(free) / speed;
      if (share < out.share) out = {share, static_cast<int>(i), a ? pair.b : pair.a, gap};
      continue;
    }
    const Vec3 point = a ? gap.on_a : gap.on_b, away = a ? gap.normal : -gap.normal;
    const Vec3 moves = velocity + cross(Vec3{0, 0, turning}, point - middle);
    const double closing = -dot(moves, away);
    if (closing < kClosesIn) continue;
    const double room = std::max(0.0, gap.distance - clearance);
    if (way.left && way.left->way + way.left->turn * norm(point - middle) <= room)
      continue;  // it ends before
    const double most = way.speed_before(room);
    if (most >= out.share * closing) continue;
    out = {most / closing, static_cast<int>(i), a ? pair.b : pair.a, gap};
  }
  return out;
}

BaseShare Guards::share_of_base(std::size_t r, double ahead, double turn) {
  Of& of = work_->robots[r];
  of.base_asked = cell_.machine.now();
  const bool knows = work_->bodies && work_->bodies->has_looked() && work_->seen >= 0;
  if (work_->off || !knows || !cell_.setup.file.guards.bases || !cell_.motions.wheels(r)) return {};
  const Vec3 velocity = work_->moment.robots[r].base.rotation * Vec3{ahead, 0, 0};
  const NearBase found = near_base(r, velocity, turn, {braking_of_base(r) / 2, kLatencyOfKeys});
  if (found.pair < 0) return {};
  return {found.share < kLeastShare ? 0 : found.share, work_->bodies->name(found.other)};
}

/// Holds the cell when a base that drives could hardly stop before a contact.
void Guards::look_at_base(std::size_t r) {
  Of& of = work_->robots[r];
  if (!base_drives(r) || !runs()) return;
  const Vec3 velocity{of.base_velocity.x, of.base_velocity.y, 0};
  moves::BaseMotion& wheels = *cell_.motions.wheels(r);
  const BaseWay way{braking_of_base(r), kLatencyOfHold, wheels.left(), wheels.pose()};
  const NearBase found = near_base(r, velocity, of.base_turning, way);
  if (found.pair < 0) return;
  of.ahead_of = {0, found.pair, found.gap, cell_.setup.file.guards.clearance};
  stop_before(r, "guard", cell_.setup.robots[r]->entry.name + " stopped before a contact: " + text_of(r));
}

}  // namespace polyarm::cell
