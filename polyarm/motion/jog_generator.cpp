#include "polyarm/motion/jog_generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::motion {
namespace {

using trajectory::MotionLimits;
using trajectory::MotionState;

/// Shares of the joints' limits: what a joint is moved with by itself, what a motion of the TCP changes with,
/// and what it slows down with before a limit. The rest is for following, and for braking.
constexpr double kSoft = 0.6, kRamp = 0.35, kBeforeLimit = 0.5, kBeforeLimitJerk = 0.25;
constexpr double kGentle = 0.5, kGentleJerk = 0.2;  // with foresight: of these again
/// While the TCP is moved no joint goes faster than it can stop in about twice this, s; and if joints cannot
/// follow, the TCP is at most so much faster than asked, and by so much in m/s.
constexpr double kQuickly = 0.1, kFaster = 1.3, kStray = 0.03;
/// A joint that may only go at this share of what is asked, as its limit is near, is done without where
/// another can take its part.
constexpr double kCramped = 0.3;
/// What moves so little, of what moves most, does not slow the others down.
constexpr double kHardly = 0.02;
/// How a TCP returns to where its reference is, 1/s, and up to which distance, m.
constexpr double kReturn = 5, kAstray = 5e-4;
/// How fast a target of the TCP is gone to where nobody says less, m/s and rad/s.
constexpr double kTargetSpeed = 1, kTargetTurning = 3;
/// A target that moves is followed in its own frame, with speed to spare; where it will be so much later, s,
/// is the direction that matters.
constexpr double kFollows = 0.9, kAhead = 0.1;
/// With what it is gone for, of what motions of the TCP change with otherwise; across its way with less.
constexpr double kLead = 1.2, kAside = 0.4, kBrakesHarder = 2;
/// Of speed limits, so that rounding and curves stay below them.
constexpr double kBelow = 0.93, kAtMost = 0.95;
/// What is kept free before the boundaries of the workspace, m, by slowing down and by the guard.
constexpr double kKeepFree = 2e-3, kKeepFreeAtLeast = 1.5e-3;
/// Places looked at while everything brakes.
constexpr std::size_t kPlaces = 20;
constexpr double kMoment = 1e-5;  // s, to tell a speed
constexpr int kHalvings = 9;
constexpr double kCreeps = 5e-3;                    // m/s, rad/s
constexpr double kHere = 2e-6, kHereTurned = 1e-5;  // m, rad

double linear(const Twist& t) {
  return std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
}
double angular(const Twist& t) {
  return std::sqrt(t[3] * t[3] + t[4] * t[4] + t[5] * t[5]);
}
bool is_zero(const Twist& t) {
  return std::all_of(t.begin(), t.end(), [](double x) { return x == 0; });
}
Twist turned(const Quaternion& r, const Twist& t) {
  const Vec3 v = r * Vec3{t[0], t[1], t[2]}, w = r * Vec3{t[3], t[4], t[5]};
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}
/// From `a` to `b`: m, and the rotation vector, in the world.
Twist between(const Pose& a, const Pose& b) {
  const Vec3 d = b.position - a.position, r = to_rotation_vector(b.rotation * inverse(a.rotation));
  return {d.x, d.y, d.z, r.x, r.y, r.z};
}
void advance(Pose& pose, const Twist& by) {
  pose.position = pose.position + Vec3{by[0], by[1], by[2]};
  const Vec3 r{by[3], by[4], by[5]};
  const double angle = norm(r);
  if (angle > 0) pose.rotation = normalized(from_axis_angle((1 / angle) * r, angle) * pose.rotation);
}

}  // namespace

const char* name(JogHold hold) {
  constexpr const char* kNames[] = {"none", "speed", "singularity", "direction", "joint limit", "workspace"};
  return kNames[static_cast<std::size_t>(hold)];
}

JogGenerator::JogGenerator(const kinematics::Chain& chain, std::vector<AxisLimits> axes, Workspace workspace,
                           double period)
    : chain_(chain), axes_(std::move(axes)), workspace_(std::move(workspace)), dt_(period), solver_(chain) {
  if (std::isfinite(chain.reach()) && chain.reach() > 1e-3) length_ = chain.reach();
  if (axes_.size() > kMostJogJoints)
    throw Error("too-many-joints",
                fmt::format("the robot has {} joints, {} can be jogged", axes_.size(), kMostJogJoints));
  for (const AxisLimits& axis : axes_) {
    gentle_acceleration_.push_back(kGentle * axis.acceleration);
    gentle_jerk_.push_back(kGentleJerk * axis.jerk);
    velocity_.push_back(axis.velocity);
    acceleration_.push_back(axis.acceleration);
    jerk_.push_back(axis.jerk);
    lower_.push_back(axis.lower);
    upper_.push_back(axis.upper);
  }
}

void JogGenerator::start(std::span<const double> q) noexcept {
  for (std::size_t j = 0; j < axes_.size(); ++j) state_[j] = {q[j], 0, 0};
  solver_.at(q);
  solver_.forget();
  reference_.on = rates_hold_ = arrived_ = false;
  kind_ = JogWish::Kind::rest;
  hold_ = JogHold::none;
  which_ = -1;
  tcp_speed_ = 0;
}

bool JogGenerator::standing() const noexcept {
  return std::all_of(state_.begin(), state_.begin() + static_cast<std::ptrdiff_t>(axes_.size()),
                     [](const AxisState& s) { return s.velocity == 0 && s.acceleration == 0; });
}

void JogGenerator::note(JogHold hold, std::size_t which) noexcept {
  if (hold < hold_) return;
  hold_ = hold;
  which_ = static_cast<std::int32_t>(which);
}

AxisLimits JogGenerator::limits_of(std::size_t j, const JogLimits& limits) const noexcept {
  AxisLimits out = axes_[j];
  out.velocity *= limits.joint_share;
  return out;
}

// --- joints -----------------------------------------------------------------------------------------------

void JogGenerator::wish_joints(const JogWish& wish, const JogLimits& limits, JogValues& rates) noexcept {
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const AxisLimits own = limits_of(j, limits);
    double v = std::isfinite(wish.joints[j]) ? wish.joints[j] : 0.0;
    if (std::abs(v) > own.velocity) {
      v = std::copysign(own.velocity, v);
      note(JogHold::speed, j);
    }
    const double room = v > 0 ? own.upper - state_[j].position : state_[j].position - own.lower;
    const double most = stopping_speed(room, kBeforeLimit * own.acceleration, kBeforeLimitJerk * own.jerk);
    if (std::abs(v) > most) {
      v = std::copysign(most, v);
      note(JogHold::joint_limit, j);
    }
    rates[j] = v;
  }
}

/// The next states on the fastest way to the target's joints; false where there is no way.
bool JogGenerator::step_to_joints(const JogWish& wish, const JogLimits& limits, States& next) noexcept {
  const std::size_t n = axes_.size();
  std::array<MotionState, kMostJogJoints> from, to, out;
  std::array<MotionLimits, kMostJogJoints> most;
  JogValues full{}, moving{};  // at full speed along the way; of the target
  double longest = 1e-12;
  bool there = true;
  for (std::size_t j = 0; j < n; ++j) {
    const double asked = std::isfinite(wish.joints[j]) ? wish.joints[j] : state_[j].position;
    const double target = std::clamp(asked, std::min(axes_[j].lower, state_[j].position),
                                     std::max(axes_[j].upper, state_[j].position));
    if (target != asked) note(JogHold::joint_limit, j);
    const double own = kBelow * limits.joint_share * wish.speed * axes_[j].velocity;
    moving[j] = target == asked ? wish.joint_speed[j] : 0.0;
    to[j] = {target, 0, 0};
    most[j] = MotionLimits::symmetric(own, kSoft * axes_[j].acceleration, kSoft * axes_[j].jerk);
    full[j] = target - state_[j].position + kAhead * moving[j];
    longest = std::max(longest, std::abs(full[j]) / own);
    there = there && target == asked && std::abs(target - state_[j].position) < 1e-9 &&
            std::abs(state_[j].velocity) < 1e-6;
  }
  arrived_ = there;
  for (double& rate : full) rate /= longest;
  const double share = std::max(throttle(limits, kGently, true, full), 1e-6);
  for (std::size_t j = 0; j < n; ++j) {
    const double own = share * most[j].max_velocity;
    moving[j] = std::clamp(moving[j], -kFollows * own, kFollows * own);
    most[j].max_velocity = own - moving[j];
    most[j].min_velocity = -own - moving[j];
    from[j] = {state_[j].position, state_[j].velocity - moving[j], state_[j].acceleration};
  }
  const trajectory::MotionOptions options{trajectory::Synchronization::time, trajectory::TargetKind::position,
                                          0};
  if (to_joints_.plan({from.data(), n}, {to.data(), n}, {most.data(), n}, options) !=
      trajectory::MotionStatus::ok)
    return false;
  to_joints_.sample(dt_, {out.data(), n});
  for (std::size_t j = 0; j < n; ++j)
    next[j] = {out[j].position + dt_ * moving[j], out[j].velocity + moving[j], out[j].acceleration};
  return true;
}

// --- the TCP ----------------------------------------------------------------------------------------------

void JogGenerator::begin_reference() noexcept {
  std::array<double, kMostJogJoints> v{};
  for (std::size_t j = 0; j < axes_.size(); ++j) v[j] = state_[j].velocity;
  reference_ = {true, tcp(), solver_.twist_of({v.data(), axes_.size()}), {}};
}

/// How quickly the TCP's velocity may change along `direction`, and how suddenly, as far as joints allow.
void JogGenerator::capability(const Twist& direction, double& acceleration, double& jerk) const noexcept {
  JogValues rates;
  solver_.reach(direction, rates);
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const double r = std::max(std::abs(rates[j]), 1e-9);
    acceleration = std::min(acceleration, kRamp * axes_[j].acceleration / r);
    jerk = std::min(jerk, kRamp * axes_[j].jerk / r);
  }
}

namespace {
/// Bounds of the TCP's acceleration and jerk along its axes, first those of its place, then of turning.
struct Pace {
  double acceleration[2] = {20, 200}, jerk[2] = {400, 4000};
};

/// Three axes of which the first lies along `v`.
std::array<Vec3, 3> axes_along(const Vec3& v) {
  const Quaternion r = rotation_between({1, 0, 0}, norm(v) > 1e-9 ? normalized(v) : Vec3{1, 0, 0});
  return {r * Vec3{1, 0, 0}, r * Vec3{0, 1, 0}, r * Vec3{0, 0, 1}};
}
Vec3 part_of(const Twist& t, std::size_t part) {
  return {t[3 * part], t[3 * part + 1], t[3 * part + 2]};
}
}  // namespace

/// Towards a velocity, in axes along it: what begins or ends at rest is straight.
void JogGenerator::ramp_reference(const Twist& wanted) noexcept {
  std::array<MotionState, 6> from, to, out;
  std::array<MotionLimits, 6> most;
  std::array<std::array<Vec3, 3>, 2> axes;
  const bool both =
      linear(wanted) + linear(reference_.twist) > 1e-9 && angular(wanted) + angular(reference_.twist) > 1e-9;
  for (std::size_t part = 0; part < 2; ++part) {
    const Vec3 goal = part_of(wanted, part), now = part_of(reference_.twist, part),
               slope = part_of(reference_.slope, part);
    axes[part] = axes_along(norm(goal) > 1e-9 ? goal : now);
    Pace pace;
    for (const Vec3& axis : axes[part]) {
      Twist along{};
      along[3 * part] = axis.x, along[3 * part + 1] = axis.y, along[3 * part + 2] = axis.z;
      // Across the way only where something has to change there.
      const bool across = &axis != &axes[part][0];
      if (across && std::abs(dot(axis, now)) + std::abs(dot(axis, slope)) < 1e-12) continue;
      capability(along, pace.acceleration[part], pace.jerk[part]);
    }
    const double share = both ? 0.5 : 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& axis = axes[part][k];
      from[3 * part + k] = {0, dot(axis, now), dot(axis, slope)};
      to[3 * part + k] = {0, k == 0 ? dot(axis, goal) : 0.0, 0};
      most[3 * part + k] = MotionLimits::symmetric(1 + 2 * std::max(norm(goal), norm(now)),
                                                   share * pace.acceleration[part], share * pace.jerk[part]);
    }
  }
  const trajectory::MotionOptions options{trajectory::Synchronization::none, trajectory::TargetKind::velocity,
                                          0};
  if (to_pose_.plan(from, to, most, options) != trajectory::MotionStatus::ok) return;
  to_pose_.sample(dt_, out);
  Twist by{};
  for (std::size_t part = 0; part < 2; ++part) {
    const auto sum = [&](double MotionState::*value, Twist& into) {
      Vec3 v;
      for (std::size_t k = 0; k < 3; ++k) v = v + out[3 * part + k].*value * axes[part][k];
      into[3 * part] = v.x, into[3 * part + 1] = v.y, into[3 * part + 2] = v.z;
    };
    sum(&MotionState::position, by);
    sum(&MotionState::velocity, reference_.twist);
    sum(&MotionState::acceleration, reference_.slope);
  }
  advance(reference_.pose, by);
}

/// How quickly the TCP's place (part 0) or its turning (1) may change along `ahead`, and along any axis.
JogGenerator::Pull JogGenerator::pull_along(const Twist& ahead, std::size_t part) const noexcept {
  Pace any, own;
  for (std::size_t k = 3 * part; k < 3 * part + 3; ++k) {
    Twist along{};
    along[k] = 1;
    capability(along, any.acceleration[part], any.jerk[part]);
  }
  const Vec3 way = part_of(ahead, part);
  const double length = norm(way);
  Twist along{};
  for (std::size_t k = 0; k < 3; ++k)
    along[3 * part + k] = length > 1e-6 ? (k == 0 ? way.x : k == 1 ? way.y : way.z) / length : 0.0;
  if (length > 1e-6)
    capability(along, own.acceleration[part], own.jerk[part]);
  else
    own = any;
  return {own.acceleration[part], own.jerk[part], any.acceleration[part], any.jerk[part]};
}

namespace {
/// Where an arm cannot change its speed as quickly as it could when it began, who would go past the target
/// brakes with some of what is kept free for that.
void brake_harder(const double (&away)[2], const std::array<MotionState, 6>& from,
                  const std::array<MotionState, 6>& to, std::array<MotionLimits, 6>& most) {
  for (std::size_t k = 0; k < 6; ++k) {
    const double left = to[k].position, v = from[k].velocity;
    if (left * v <= 0 || away[k / 3] < 1e-5) continue;
    const double can = stopping_speed(std::abs(left), most[k].max_acceleration, most[k].max_jerk);
    if (!(std::abs(v) > can)) continue;
    const double more = std::min(v * v / (can * can), kBrakesHarder);
    most[k].max_acceleration *= more;
    most[k].min_acceleration *= more;
    most[k].max_jerk *= more;
  }
}
}  // namespace

/// Towards a pose that moves, in a chart about where the reference is.
void JogGenerator::lead_reference(const JogWish& wish, const JogLimits& limits, double share) noexcept {
  Twist error = between(reference_.pose, wish.target);
  std::array<double, kMostJogJoints> rates;
  if (solver_.columns() < 6) {  // as far as the arm can
    solver_.reach(error, rates);
    error = solver_.twist_of({rates.data(), axes_.size()});
  }
  std::array<MotionState, 6> from, to, out;
  std::array<MotionLimits, 6> most;
  // Each axis has its share of the speed along the way, and no less than a part of it to correct with.
  const double away[2] = {linear(error), angular(error)};
  Twist ahead, moving{};
  for (std::size_t k = 0; k < 6; ++k) ahead[k] = error[k] + kAhead * wish.twist[k];
  const double way[2] = {linear(ahead), angular(ahead)}, rate[2] = {linear(wish.twist), angular(wish.twist)};
  const double speed[2] = {kBelow * wish.speed * std::min(limits.tcp_speed, kTargetSpeed),
                           kBelow * wish.speed * std::min(limits.tcp_turning, kTargetTurning)};
  std::array<Pull, 2> pull{};
  for (std::size_t part = 0; part < 2; ++part) pull[part] = pull_along(ahead, part);
  for (std::size_t k = 0; k < 6; ++k) {
    const double part = way[k / 3] > 1e-6 ? std::abs(ahead[k]) / way[k / 3] : 0.0;
    const double can = share * speed[k / 3];
    const double v = std::max(can * std::max(part, 0.1), 1e-6);
    moving[k] = wish.twist[k] * (rate[k / 3] > kFollows * can ? kFollows * can / rate[k / 3] : 1.0);
    moving[k] = std::clamp(moving[k], -kFollows * v, kFollows * v);
    from[k] = {0, reference_.twist[k] - moving[k], reference_.slope[k]};
    to[k] = {error[k], 0, 0};
    const Pull& p = pull[k / 3];
    most[k] = MotionLimits::symmetric(v, kLead * std::max(part * p.acceleration, kAside * p.any_acceleration),
                                      kLead * std::max(part * p.jerk, kAside * p.any_jerk));
    most[k].max_velocity -= moving[k];
    most[k].min_velocity -= moving[k];
  }
  brake_harder(away, from, to, most);
  const trajectory::MotionOptions options{trajectory::Synchronization::phase,
                                          trajectory::TargetKind::position, 0};
  if (to_pose_.plan(from, to, most, options) != trajectory::MotionStatus::ok) return;
  to_pose_.sample(dt_, out);
  Twist by{};
  for (std::size_t k = 0; k < 6; ++k) {
    by[k] = out[k].position + dt_ * moving[k];
    reference_.twist[k] = out[k].velocity + moving[k];
    reference_.slope[k] = out[k].acceleration;
  }
  advance(reference_.pose, by);
  const Twist left = between(tcp(), reference_.pose);
  arrived_ = away[0] < kHere && away[1] < kHereTurned && linear(reference_.twist) < 1e-5 &&
             angular(reference_.twist) < 1e-4 &&
             (solver_.columns() < 6 || (linear(left) < kHere && angular(left) < kHereTurned));
}

void JogGenerator::wish_tcp(const JogWish& wish, const JogLimits& limits, JogValues& rates) noexcept {
  if (!reference_.on) begin_reference();
  Twist wanted = wish.kind == JogWish::Kind::tcp_velocity ? wish.twist : Twist{};
  if (wanted != asked_) solver_.forget();
  asked_ = wanted;
  if (wish.tool_frame) wanted = turned(tcp().rotation, wanted);
  const double over =
      std::max(linear(wanted) / (kBelow * limits.tcp_speed), angular(wanted) / (kBelow * limits.tcp_turning));
  if (over > 1) {
    for (double& x : wanted) x /= over;
    note(JogHold::speed, 0);
  }
  if (wish.kind == JogWish::Kind::tcp_target) wanted = way_to(wish, limits);
  std::array<double, kMostJogJoints> velocity;
  for (std::size_t j = 0; j < axes_.size(); ++j)
    velocity[j] = std::min(limits.joint_share * velocity_[j], kQuickly * acceleration_[j]);
  const std::span<const double> fast{velocity.data(), axes_.size()};

  // How much of it there can be, with foresight: what the reference goes for.
  TwistSolver::Solution solution;
  solver_.solve(wanted, {fast, gentle_acceleration_, gentle_jerk_, lower_, upper_}, solution);
  // Joints to spare do without those that stand before a limit.
  for (std::size_t j = 0; j < axes_.size() && solver_.spare() > 0; ++j) {
    const double r = solution.rates[j];
    const double room = r > 0 ? axes_[j].upper - state_[j].position : state_[j].position - axes_[j].lower;
    if (std::abs(r) < 1e-9 || stopping_speed(room, kGently.acceleration * axes_[j].acceleration,
                                             kGently.jerk * axes_[j].jerk) > kCramped * std::abs(r))
      continue;
    solver_.lock(j);
    solver_.solve(wanted, {fast, gentle_acceleration_, gentle_jerk_, lower_, upper_}, solution);
    j = 0;
  }
  tell(solution);
  const double much = solution.share * throttle(limits, kGently, true, solution.rates);
  if (wish.kind == JogWish::Kind::tcp_target) {
    lead_reference(wish, limits, much);
  } else {
    for (double& x : wanted) x *= much;
    ramp_reference(wanted);
  }

  // And what the joints do for it.
  Twist twist = reference_.twist;
  const Twist error = between(tcp(), reference_.pose);
  if (linear(error) > kAstray || angular(error) > kAstray / length_)
    reference_.pose = tcp();  // it goes on from where it is
  else
    for (std::size_t k = 0; k < 6; ++k) twist[k] += kReturn * error[k];
  solver_.solve(twist, {fast, acceleration_, jerk_, lower_, upper_}, solution);
  rates = solution.rates;
  const double share = solution.share * throttle(limits, kFirmly, true, rates);
  if (share == 1 && solution.outcome == TwistOutcome::exact && solver_.columns() >= 6) return;
  // It is held back: the reference stays with the arm.
  reference_.pose = tcp();
  for (double& x : reference_.twist) x *= share;
  // Where it hardly moves it must not gather speed against what holds it.
  const bool creeps = share < 1 && linear(reference_.twist) < kCreeps && angular(reference_.twist) < kCreeps;
  for (double& x : reference_.slope) x *= creeps ? 0 : share;
}

/// The twist that leads to the target at the speed that is allowed.
Twist JogGenerator::way_to(const JogWish& wish, const JogLimits& limits) const noexcept {
  Twist out = between(reference_.pose, wish.target);
  for (std::size_t k = 0; k < 6; ++k) out[k] += kAhead * wish.twist[k];
  const double time =
      std::max({linear(out) / (kBelow * wish.speed * std::min(limits.tcp_speed, kTargetSpeed)),
                angular(out) / (kBelow * wish.speed * std::min(limits.tcp_turning, kTargetTurning)), 1e-9});
  for (double& x : out) x /= time;
  return out;
}

void JogGenerator::tell(const TwistSolver::Solution& solution) noexcept {
  switch (solution.outcome) {
    case TwistOutcome::exact:
      return;
    case TwistOutcome::unavailable:
      return note(JogHold::direction, 0);
    case TwistOutcome::slowed:
      return note(solution.share < 0.5 ? JogHold::singularity : JogHold::speed, 0);
    default:
      return note(JogHold::singularity, 0);
  }
}

// --- before limits ----------------------------------------------------------------------------------------

/// Slows `rates` down so that everything can stop in time along the way, and below the speed limits.
/// `common`: before joint limits, too. Returns the share that is left.
double JogGenerator::throttle(const JogLimits& limits, Before before, bool common,
                              JogValues& rates) noexcept {
  double share = 1, a = 1e300, jerk = 1e300, most = 1e-9;
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const double r = std::max(std::abs(rates[j]), 1e-12);
    most = std::max(most, r / axes_[j].velocity);
    a = std::min(a, before.acceleration * axes_[j].acceleration / r);
    jerk = std::min(jerk, before.jerk * axes_[j].jerk / r);
  }
  const auto slow = [&](double left, JogHold hold, std::size_t which) {
    if (left < 0.999) note(hold, which);
    share = std::min(share, left);
  };
  for (std::size_t j = 0; common && j < axes_.size(); ++j) {
    const double r = std::abs(rates[j]);
    if (r < kHardly * most * axes_[j].velocity) continue;  // left to the guard
    slow(limits.joint_share * axes_[j].velocity / r, JogHold::speed, j);
    const double room =
        rates[j] > 0 ? axes_[j].upper - state_[j].position : state_[j].position - axes_[j].lower;
    slow(stopping_speed(room / r, a, jerk), JogHold::joint_limit, j);
  }
  const Twist twist = solver_.twist_of({rates.data(), axes_.size()});
  const double speed = linear(twist);
  if (speed < 1e-9) {
    for (double& r : rates) r *= share;
    return share;
  }
  slow(kBelow * limits.tcp_speed / speed, JogHold::speed, 0);
  for (std::size_t i = 0; i < workspace_.boundaries(); ++i) {
    const Workspace::Distance d = workspace_.distance(i, solver_.position());
    const double closing = -dot(d.away, {twist[0], twist[1], twist[2]});
    if (closing > 1e-4 * speed)
      slow(stopping_speed((d.distance - kKeepFree) / closing, a, jerk), JogHold::workspace,
           workspace_.zone_of(i));
  }
  for (double& r : rates) r *= share;
  return share;
}

void JogGenerator::follow(const JogValues& rates, const JogLimits& limits, States& next) noexcept {
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    AxisLimits own = limits_of(j, limits);
    double slope = 0;
    if (rates_hold_) slope = (rates[j] - rates_[j]) / dt_;
    slope = std::clamp(slope, -0.8 * own.acceleration, 0.8 * own.acceleration);
    if (!reference_.on) own.acceleration *= kSoft, own.jerk *= kSoft;
    next[j] = towards_velocity(state_[j], rates[j], slope, own, dt_);
  }
}

/// What happens while every joint brakes: how near the TCP comes to each boundary, and how fast it is.
struct JogGenerator::Ahead {
  std::array<double, Workspace::kMostBoundaries> distance;
  double speed = 0, at_once = 0;  // the most, and at the beginning
};

void JogGenerator::look_ahead(const States& from, Ahead& out) noexcept {
  const std::size_t n = axes_.size();
  std::array<double, kMostJogJoints> q{}, soon{};
  double duration = 0;
  for (std::size_t j = 0; j < n; ++j)
    duration = std::max(duration, AxisBrake(from[j], axes_[j].acceleration, axes_[j].jerk).duration());
  out.speed = out.at_once = 0;
  out.distance.fill(1e300);
  for (std::size_t k = 0; k <= kPlaces + n; ++k) {
    const double part = static_cast<double>(std::min(k, kPlaces)) / kPlaces;
    double t = duration * part * part;  // closer together where it is fast still
    if (k > kPlaces) {                  // and where a joint is fastest
      const AxisState& s = from[k - kPlaces - 1];
      if (s.acceleration * s.velocity <= 0) continue;
      t = std::abs(s.acceleration) / axes_[k - kPlaces - 1].jerk;
    }
    for (std::size_t j = 0; j < n; ++j) {
      const AxisState s = AxisBrake(from[j], axes_[j].acceleration, axes_[j].jerk).at(t);
      q[j] = s.position;
      soon[j] = s.position + kMoment * s.velocity;
    }
    const Vec3 at = chain_.forward({q.data(), n}).position;
    for (std::size_t i = 0; i < workspace_.boundaries(); ++i)
      out.distance[i] = std::min(out.distance[i], workspace_.distance(i, at).distance);
    out.speed = std::max(out.speed, norm(chain_.forward({soon.data(), n}).position - at) / kMoment);
    if (k == 0) out.at_once = out.speed;
  }
}

/// The last word: from where this step leads, everything can still stop.
void JogGenerator::guard(const JogLimits& limits, States& next) noexcept {
  const std::size_t n = axes_.size();
  States braked;
  for (std::size_t j = 0; j < n; ++j) {
    const AxisGuard axis(state_[j], limits_of(j, limits), dt_);
    bool cut = false;
    const AxisState wanted = next[j];
    next[j] = axis.nearest(wanted, cut);
    braked[j] = axis.braked();
    if (!cut) continue;
    const AxisBrake brake(wanted, axes_[j].acceleration, axes_[j].jerk);
    const bool at_limit = brake.highest() > axes_[j].upper || brake.lowest() < axes_[j].lower;
    note(at_limit ? JogHold::joint_limit : JogHold::speed, j);
  }
  const bool any_speed = limits.tcp_speed < 1e3 || reference_.on;
  const double stray = reference_.on ? kStray + kFaster * std::max(linear(asked_), linear(reference_.twist))
                                     : limits.tcp_speed;
  if (workspace_.empty() && !any_speed) return;
  Ahead now, then;  // of braking from now on, which is what cannot be helped
  look_ahead(braked, now);
  std::array<double, kMostJogJoints> q{};
  for (std::size_t j = 0; j < n; ++j) q[j] = state_[j].position;
  const Vec3 here = chain_.forward({q.data(), n}).position;
  std::size_t worst = 0;
  const auto safe = [&](const States& states) {
    look_ahead(states, then);
    for (std::size_t i = 0; i < workspace_.boundaries(); ++i) {
      // Who comes too near even braking brakes, or moves away.
      const bool near = now.distance[i] < kKeepFreeAtLeast;
      const double least = near ? workspace_.distance(i, here).distance : kKeepFreeAtLeast;
      worst = i;
      if (then.distance[i] < std::min(kKeepFreeAtLeast, least) - 1e-12) return false;
    }
    worst = workspace_.boundaries();
    // Who would be too fast even braking brakes; a little more each time would add up.
    return !any_speed || (std::max(then.speed, now.speed) <= kAtMost * limits.tcp_speed &&
                          then.at_once <= std::max(stray, now.at_once) + 1e-12);
  };
  if (safe(next)) return;
  if (worst < workspace_.boundaries())
    note(JogHold::workspace, workspace_.zone_of(worst));
  else
    note(JogHold::speed, 0);
  double low = 0, high = 1;
  States mix;
  const auto set = [&](double share) {
    for (std::size_t j = 0; j < n; ++j) mix[j] = mixed(braked[j], next[j], share);
  };
  for (int i = 0; i < kHalvings; ++i) {
    set((low + high) / 2);
    (safe(mix) ? low : high) = (low + high) / 2;
  }
  set(low);
  next = mix;
}

// --- a cycle ----------------------------------------------------------------------------------------------

void JogGenerator::step(const JogWish& wish, const JogLimits& limits) noexcept {
  using Kind = JogWish::Kind;
  const std::size_t n = axes_.size();
  hold_ = JogHold::none;
  which_ = -1;
  arrived_ = false;
  if (wish.kind == Kind::rest && standing()) {
    reference_.on = rates_hold_ = false;
    kind_ = Kind::rest;
    tcp_speed_ = 0;
    return;
  }
  const auto of_tcp = [](Kind kind) { return kind == Kind::tcp_velocity || kind == Kind::tcp_target; };
  if (!of_tcp(wish.kind) && (wish.kind != Kind::rest || wish.at_once)) reference_.on = false;
  if (wish.kind != kind_ && !(wish.kind == Kind::rest && reference_.on)) rates_hold_ = false;
  if (wish.kind == Kind::joint_velocity && wish.joints != wanted_) rates_hold_ = false;
  kind_ = wish.kind;
  wanted_ = wish.joints;

  std::array<double, kMostJogJoints> soon{};
  for (std::size_t j = 0; j < n; ++j)
    soon[j] = state_[j].position + dt_ * (state_[j].velocity + dt_ / 2 * state_[j].acceleration);
  solver_.at({soon.data(), n});
  JogValues rates{};
  States next{};
  bool planned = false;
  if (wish.kind == Kind::joint_velocity) {
    wish_joints(wish, limits, rates);
    throttle(limits, kFirmly, false, rates);
  } else if (wish.kind == Kind::joint_target) {
    planned = step_to_joints(wish, limits, next);
  } else if (of_tcp(wish.kind) || reference_.on) {
    wish_tcp(wish, limits, rates);
    if (wish.kind == Kind::rest && is_zero(reference_.twist)) reference_.on = rates_hold_ = false;
    if (wish.kind == Kind::rest) {
      hold_ = JogHold::none;
      which_ = -1;
      if (!reference_.on) rates = {};
    }
  }
  if (wish.kind == Kind::rest && wish.at_once)
    for (std::size_t j = 0; j < n; ++j)
      next[j] = AxisBrake(state_[j], axes_[j].acceleration, axes_[j].jerk).at(dt_);
  else if (!planned)
    follow(rates, limits, next);
  rates_ = rates;
  rates_hold_ = !planned && !(wish.kind == Kind::rest && !reference_.on);
  guard(limits, next);
  std::array<double, kMostJogJoints> velocity{};
  for (std::size_t j = 0; j < n; ++j) {
    state_[j] = next[j];
    velocity[j] = next[j].velocity;
  }
  tcp_speed_ = linear(solver_.twist_of({velocity.data(), n}));
}

}  // namespace polyarm::motion
