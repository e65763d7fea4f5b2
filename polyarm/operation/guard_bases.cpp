/// Guards of bases that drive: a base slows down and stops before it, or what it carries, touches something.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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
/// Where a controller states no deceleration, m/s² and rad/s².
constexpr double kDeceleration = 1;
/// Nearer to something than the clearance, a base on a way that was planned is not slower than this, m/s; a
/// point of it on a turn counts as so far from the middle at least, m.
constexpr double kSlowest = 0.02, kLeastRadius = 0.1;
/// A base that comes no nearer than this to something leaves it or passes it, m.
constexpr double kSameDistance = 1e-4;
/// Its measured speed is so old, s: a base that brakes at the end of its leg is slower already. It may stop
/// so far beyond the end, m or rad.
constexpr double kOldSpeed = 0.1, kBeyond = 0.02;

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
  /// The highest speed of the present leg beside what is nearer than the clearance, m/s or rad/s.
  double most = std::numeric_limits<double>::infinity();
};

/// Where a base goes and how it comes to rest.
struct Guards::BaseWay {
  double braking = kDeceleration;                    ///< m/s²
  double turn_braking = kDeceleration;               ///< rad/s²
  double latency = 0;                                ///< s, before it brakes
  double clearance = 0;                              ///< m, to be kept from everything else
  std::optional<moves::BaseMotion::Left> left = {};  ///< of a move that ends by itself; nothing: it drives on
  Pose T_world_base = {};                            ///< with `left`: of the frame that its wheels move

  bool is_known() const { return left && (left->way > 0 || left->turn > 0); }
  bool turns() const { return left->way <= 0; }
  /// False if it is too fast to come to rest at the end of its leg: somebody else drives it.
  bool explains(double speed, double turning) const {
    if (!is_known()) return true;  // how far it rolls is known
    const double of_leg = turns() ? turning : speed;
    const double stop = left->braking > 0 ? of_leg / (2 * left->braking) - kOldSpeed : 0;
    return of_leg * stop <= (turns() ? left->turn : left->way) + kBeyond;
  }
  /// The highest speed with which it comes to rest within this length; of a turn in rad and rad/s.
  double speed_before(double room) const { return speed_before(room, braking); }
  double leg_speed_before(double room) const { return speed_before(room, turns() ? turn_braking : braking); }
  /// How far it comes along its line, arc or turn with this speed, if it brakes.
  double braking_length(double speed) const {
    const double rest = turns() ? left->turn : left->way;
    return std::min(rest, speed * (latency + speed / (2 * (turns() ? turn_braking : braking))));
  }
  /// No point of the base moves farther for each m or rad of the leg.
  double lever() const { return turns() ? kFarthestPoint : 1 + std::abs(left->curvature) * kFarthestPoint; }
  /// The distance that the base keeps on its leg from what is so far away now. What a way was planned with is
  /// enough, but not for what moves: it was elsewhere then.
  double keep(double distance, bool other_moves) const {
    const double now = kept_on_way(distance, clearance);
    if (other_moves || !left->kept || *left->kept <= 0) return now;
    return std::min(now, kept_on_way(*left->kept, clearance));
  }
  /// How far it drives on its leg until a body of it, `a` or else `b` of the pair, is nearer than `keep` to
  /// the other one; at most `most`. `gap`: now, and then there.
  double free(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, double keep, double most,
              GuardGap& gap) const;
  /// The distance of the pair after so much of the leg, or a bound that is at least `enough`.
  double distance_after(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, double driven,
                        double enough) const {
    return bodies.gap_after(pair, a, after(driven), enough).distance;
  }

  /// Looks along the leg that it drives with the speed `fast`; `middle`: about which it turns. `other_moves`:
  /// the body of the pair that it does not carry is one of a robot that moves.
  void look(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, bool other_moves, double fast,
            const Vec3& middle, GuardGap gap, NearBase& out) const;

 private:
  double speed_before(double room, double most) const {
    return most * (std::sqrt(latency * latency + 2 * room / most) - latency);
  }
  Pose after(double driven) const;
};

/// The motion in the world until it has driven so far along its leg.
Pose Guards::BaseWay::after(double driven) const {
  const Vec3 ahead = T_world_base.rotation * Vec3{1, 0, 0};
  const surroundings::BasePlace now{T_world_base.position.x, T_world_base.position.y,
                                    std::atan2(ahead.y, ahead.x)};
  const double length = left->backwards ? -driven : driven;
  surroundings::BasePlace then = now;
  if (turns())
    then.heading += length;
  else
    then = surroundings::along(now, left->curvature, length);
  const auto pose = [](const surroundings::BasePlace& at) {
    return Pose{{at.x, at.y, 0}, from_rpy(0, 0, at.heading)};
  };
  return pose(then) * inverse(pose(now));
}

double Guards::BaseWay::free(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, double keep,
                             double most, GuardGap& gap) const {
  double driven = 0, proven = 0;  // the distances are enough as far as `proven`
  while (gap.distance >= keep) {
    if (driven >= most) return most;
    proven = driven + (gap.distance - keep) / lever();
    driven = std::min(most, std::max(proven, driven + kStepOfWay));
    gap = bodies.gap_after(pair, a, after(driven), keep + lever() * (most - driven));
  }
  return proven;
}

void Guards::BaseWay::look(surroundings::GuardBodies& bodies, const GuardPair& pair, bool a, bool other_moves,
                           double fast, const Vec3& middle, GuardGap gap, NearBase& out) const {
  const double most = braking_length(fast), now = gap.distance;
  if (now < clearance || left->kept) {
    const double then = distance_after(bodies, pair, a, most, clearance), least = std::min(now, then);
    if (least < clearance && then <= now + kSameDistance) {  // it does not leave it
      const double radius = turns() ? std::max(norm((a ? gap.on_a : gap.on_b) - middle), kLeastRadius) : 1;
      out.most = std::min(out.most, std::max(speed_before(least), kSlowest) / radius);
    }
  }
  const double driven = free(bodies, pair, a, keep(now, other_moves), most, gap);
  if (driven >= most) return;
  const double share = leg_speed_before(driven) / fast;
  if (share >= out.share) return;
  out.share = share, out.gap = gap;
  out.pair = static_cast<int>(&pair - bodies.pairs().data());
  out.other = a ? pair.b : pair.a;
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

namespace {
double braking_of(const controllers::SpeedLimits& limits) {
  for (const double limit : {limits.max_deceleration, limits.max_acceleration})
    if (std::isfinite(limit) && limit != 0) return std::abs(limit);
  return kDeceleration;
}
}  // namespace

double Guards::braking_of_base(std::size_t r) const {
  return braking_of(cell_.motions.wheels(r)->controller().linear_limits());
}

/// `velocity`: of the base in the world, `turning`: about the vertical.
Guards::NearBase Guards::near_base(std::size_t r, const Vec3& velocity, double turning,
                                   const BaseWay& way) const {
  NearBase out;
  surroundings::GuardBodies& bodies = *work_->bodies;
  const Vec3 middle = work_->moment.robots[r].base.position;
  /// True if `is` is true of this robot, or of one that carries it.
  const auto is_or_rides = [&](int robot, const auto& is) {
    for (std::size_t steps = 0; robot >= 0 && steps < work_->robots.size(); ++steps) {
      if (is(static_cast<std::size_t>(robot))) return true;
      const std::string& on = cell_.setup.robots[static_cast<std::size_t>(robot)]->entry.on;
      robot = -1;
      for (std::size_t k = 0; k < work_->robots.size() && !on.empty(); ++k)
        if (cell_.setup.robots[k]->entry.name == on) robot = static_cast<int>(k);
    }
    return false;
  };
  const auto is_carried = [&](int robot) {
    return is_or_rides(robot, [&](std::size_t k) { return k == r; });
  };
  const auto is_moving = [&](int robot) {
    return is_or_rides(robot, [&](std::size_t k) {
      const std::vector<double>& joints = work_->robots[k].velocity;
      return base_drives(k) || has_moved_since_drive(r, k) ||
             std::any_of(joints.begin(), joints.end(), [](double v) { return std::abs(v) > kBaseStands; });
    });
  };
  using Kind = surroundings::BodyKind;
  const double fastest = norm(velocity) + std::abs(turning) * kFarthestPoint;
  const double clearance = cell_.setup.file.guards.clearance;
  double within = clearance + fastest * fastest / (2 * way.braking) + fastest * way.latency;
  const double of_leg = way.is_known() && way.turns() ? std::abs(turning) : norm(velocity);
  if (way.is_known()) within = std::max(within, clearance + way.lever() * way.braking_length(of_leg));
  for (std::size_t i = 0; i < bodies.pairs().size(); ++i) {
    const GuardPair& pair = bodies.pairs()[i];
    if (!pair.active || pair.own || pair.of_part || pair.slack >= within) continue;
    const bool a = is_carried(pair.robot_a), b = is_carried(pair.robot_b);
    if (a == b || bodies.kind(a ? pair.b : pair.a) == Kind::floor) continue;
    const GuardGap gap = bodies.gap_of(pair, within);
    if (gap.distance >= within) continue;
    if (way.is_known()) {
      way.look(bodies, pair, a, is_moving(a ? pair.robot_b : pair.robot_a), of_leg, middle, gap, out);
      continue;
    }
    if (way.left) continue;  // it rolls out after its leg
    const Vec3 point = a ? gap.on_a : gap.on_b, away = a ? gap.normal : -gap.normal;
    const Vec3 moves = velocity + cross(Vec3{0, 0, turning}, point - middle);
    const double closing = -dot(moves, away);
    if (closing < kClosesIn) continue;
    const double room = std::max(0.0, gap.distance - clearance);
    const double most = way.speed_before(room);
    if (most >= out.share * closing) continue;
    out.share = most / closing, out.pair = static_cast<int>(i), out.gap = gap;
    out.other = a ? pair.b : pair.a;
  }
  return out;
}

BaseShare Guards::share_of_base(std::size_t r, double ahead, double turn) {
  Of& of = work_->robots[r];
  of.base_asked = cell_.machine.now();
  const bool knows = work_->bodies && work_->bodies->has_looked() && work_->seen >= 0;
  if (work_->off || !knows || !cell_.setup.file.guards.bases || !cell_.motions.wheels(r)) return {};
  const Vec3 velocity = work_->moment.robots[r].base.rotation * Vec3{ahead, 0, 0};
  const NearBase found =
      near_base(r, velocity, turn,
                {braking_of_base(r) / 2, kDeceleration, kLatencyOfKeys, cell_.setup.file.guards.clearance});
  if (found.pair < 0) return {};
  return {found.share < kLeastShare ? 0 : found.share, work_->bodies->name(found.other)};
}

/// True if the robot `k` is elsewhere than when the present move of the base `r` began: its way was planned
/// with the robot there.
bool Guards::has_moved_since_drive(std::size_t r, std::size_t k) const {
  constexpr double kSamePlace = 1e-3;  // m and rad
  const std::vector<surroundings::Moment::RobotState>& then = work_->robots[r].at_drive_start.robots;
  if (k >= then.size()) return false;
  const surroundings::Moment::RobotState &was = then[k], &is = work_->moment.robots[k];
  if (norm(is.base.position - was.base.position) > kSamePlace ||
      angle_between(is.base.rotation, was.base.rotation) > kSamePlace)
    return true;
  return !std::equal(is.joints.begin(), is.joints.end(), was.joints.begin(), was.joints.end(),
                     [](double a, double b) { return std::abs(a - b) <= kSamePlace; });
}

/// Holds the cell when a base that drives could hardly stop before a contact.
void Guards::look_at_base(std::size_t r) {
  Of& of = work_->robots[r];
  if (moves::BaseMotion* const wheels = cell_.motions.wheels(r)) {
    wheels->set_most(std::numeric_limits<double>::infinity());
    if (std::exchange(of.drive, wheels->last_id()) != of.drive) of.at_drive_start = work_->moment;
  }
  if (!base_drives(r) || !runs()) return;
  const Vec3 velocity{of.base_velocity.x, of.base_velocity.y, 0};
  moves::BaseMotion& wheels = *cell_.motions.wheels(r);
  BaseWay way{braking_of_base(r), braking_of(wheels.controller().angular_limits()),
              kLatencyOfHold,     cell_.setup.file.guards.clearance,
              wheels.left(),      wheels.pose()};
  if (!way.explains(norm(velocity), std::abs(of.base_turning))) way.left.reset();
  const NearBase found = near_base(r, velocity, of.base_turning, way);
  wheels.set_most(found.most);
  if (found.pair < 0) return;
  of.ahead_of = {0, found.pair, found.gap, cell_.setup.file.guards.clearance};
  stop_before(r, "guard", cell_.setup.robots[r]->entry.name + " stopped before a contact: " + text_of(r));
}

}  // namespace polyarm::cell
