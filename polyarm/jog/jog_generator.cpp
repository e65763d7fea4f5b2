#include "polyarm/jog/jog_generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::jog {
namespace {

using trajectory::MotionLimits;
using trajectory::MotionState;

/// Shares of the joints' limits for a joint's own motion, and for slowing down before a limit. The rest is
/// reserved for following and for braking.
constexpr double kSoft = 0.6, kBeforeLimit = 0.5, kBeforeLimitJerk = 0.25;
constexpr double kGentle = 0.5, kGentleJerk = 0.2;  // further factors, with foresight
/// While the TCP moves, no joint goes faster than it can stop in about twice kQuickly, s. If joints cannot
/// follow, the TCP is at most kFaster times as fast as requested, plus kStray in m/s.
constexpr double kQuickly = 0.1, kFaster = 1.3, kStray = 0.03;
/// A joint whose limit allows less than this share of the request is left out if another can take its part.
constexpr double kCramped = 0.3;
/// A motion smaller than this share of the largest one does not slow the others down.
constexpr double kHardly = 0.02;
/// Rate at which the TCP returns to its lead, 1/s, and the largest distance for it, m.
constexpr double kReturn = 5, kAstray = 5e-4;
/// Default speeds towards a target of the TCP, m/s and rad/s.
constexpr double kTargetSpeed = 1, kTargetTurning = 3;
/// Shares of speed limits, so that rounding and curves stay below them.
constexpr double kBelow = 0.93, kAtMost = 0.95;
/// Distance that the guard keeps from the boundaries of the workspace, m or rad.
constexpr double kKeepFreeAtLeast = 1.5e-3;
/// What curved motion along a barrier may take of its room, m.
constexpr double kBeside = 3e-4;
/// Where more is taken already, what one cycle may take: a body between two others can go along them, slowly.
constexpr double kDeeperInACycle = 1e-8;
/// Number of samples while all joints brake.
constexpr std::size_t kPlaces = 20;
constexpr double kMoment = 1e-5;  // s, step of a numeric derivative
constexpr int kHalvings = 9;

TcpLead::Target target_of(const JogSetpoint& wish, const JogLimits& limits) {
  return {wish.target, wish.twist, kBelow * wish.speed * std::min(limits.tcp_speed, kTargetSpeed),
          kBelow * wish.speed * std::min(limits.tcp_turning, kTargetTurning)};
}
bool is_zero(const Twist& t) {
  return std::all_of(t.begin(), t.end(), [](double x) { return x == 0; });
}

}  // namespace

const char* name(JogHold hold) {
  constexpr const char* kNames[] = {"none", "speed", "singularity", "direction", "joint limit", "workspace", "body"};
  return kNames[static_cast<std::size_t>(hold)];
}

JogGenerator::JogGenerator(const kinematics::Chain& chain, std::vector<AxisLimits> axes,
                           moves::Workspace workspace, double period)
    : chain_(chain),
      axes_(std::move(axes)),
      workspace_(std::move(workspace)),
      dt_(period),
      solver_(chain),
      lead_(axes_, period),
      line_(chain, {axes_.data(), std::min(axes_.size(), kMostJogJoints)}, period) {
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
  lead_.end();
  line_.end();
  rates_hold_ = arrived_ = false;
  kind_ = JogSetpoint::Kind::rest;
  hold_ = JogHold::none;
  which_ = -1;
  tcp_speed_ = 0;
}

bool JogGenerator::standing() const noexcept {
  return std::all_of(state_.begin(), state_.begin() + static_cast<std::ptrdiff_t>(axes_.size()),
                     [](const AxisState& s) { return s.velocity == 0 && s.acceleration == 0; });
}

void JogGenerator::note(JogHold hold, std::size_t which) noexcept {
  if (hold == JogHold::none || hold < hold_) return;
  hold_ = hold;
  which_ = static_cast<std::int32_t>(which);
}

AxisLimits JogGenerator::limits_of(std::size_t j, const JogLimits& limits) const noexcept {
  AxisLimits out = axes_[j];
  out.velocity *= limits.joint_share;
  return out;
}

// --- joints -----------------------------------------------------------------------------------------------

void JogGenerator::setpoint_joints(const JogSetpoint& wish, const JogLimits& limits, JogValues& rates) noexcept {
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

/// All joints move in proportion to their remaining distance; the one with the longest distance leads.
/// `limits` of all joints. False if the joints are not in proportion now.
bool JogGenerator::step_straight(std::span<const MotionState> to, std::span<const MotionLimits> limits,
                                 States& next) noexcept {
  // A joint out of proportion comes into it within this cycle, with at most this share of its jerk.
  constexpr double kJump = 0.1;
  std::size_t lead = 0;
  const auto left = [&](std::size_t j) { return to[j].position - state_[j].position; };
  for (std::size_t j = 1; j < to.size(); ++j)
    if (std::abs(left(j)) > std::abs(left(lead))) lead = j;
  if (std::abs(left(lead)) < 1e-9) return false;
  MotionLimits all = limits[lead];
  for (std::size_t j = 0; j < to.size(); ++j) {
    const double share = left(j) / left(lead), size = std::max(std::abs(share), 1e-9);
    const double jump = kJump * axes_[j].jerk * dt_;
    if (std::abs(state_[j].velocity - share * state_[lead].velocity) > jump * dt_ ||
        std::abs(state_[j].acceleration - share * state_[lead].acceleration) > jump)
      return false;
    all.max_velocity = std::min(all.max_velocity, limits[j].max_velocity / size);
    all.max_acceleration = std::min(all.max_acceleration, limits[j].max_acceleration / size);
    all.max_jerk = std::min(all.max_jerk, limits[j].max_jerk / size);
  }
  all = MotionLimits::symmetric(all.max_velocity, all.max_acceleration, all.max_jerk);
  const MotionState from{state_[lead].position, state_[lead].velocity, state_[lead].acceleration};
  if (to_joints_.plan({&from, 1}, {&to[lead], 1}, {&all, 1}, {}) != trajectory::MotionStatus::ok)
    return false;
  MotionState out;
  to_joints_.sample(dt_, {&out, 1});
  for (std::size_t j = 0; j < to.size(); ++j) {
    const double share = left(j) / left(lead);
    next[j] = {state_[j].position + share * (out.position - from.position), share * out.velocity,
               share * out.acceleration};
  }
  return true;
}

/// The next states on the fastest path to the target's joint values; the path is straight if the target is at
/// rest. False if there is no path.
bool JogGenerator::step_to_joints(const JogSetpoint& wish, const JogLimits& limits, States& next) noexcept {
  const std::size_t n = axes_.size();
  std::array<MotionState, kMostJogJoints> from, to, out;
  std::array<MotionLimits, kMostJogJoints> most;
  JogValues full{}, moving{};  // full: at full speed along the path; moving: of the target
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
    full[j] = target - state_[j].position + TcpLead::kAhead * moving[j];
    longest = std::max(longest, std::abs(full[j]) / own);
    there = there && target == asked && std::abs(target - state_[j].position) < 1e-9 &&
            std::abs(state_[j].velocity) < 1e-6;
  }
  arrived_ = there;
  for (double& rate : full) rate /= longest;
  const double share = std::max(throttle(limits, kGently, true, full), 1e-6);
  for (std::size_t j = 0; j < n; ++j) {
    const double own = share * most[j].max_velocity;
    moving[j] = std::clamp(moving[j], -TcpLead::kFollows * own, TcpLead::kFollows * own);
    most[j].max_velocity = own - moving[j];
    most[j].min_velocity = -own - moving[j];
    from[j] = {state_[j].position, state_[j].velocity - moving[j], state_[j].acceleration};
  }
  const bool rests = std::all_of(moving.begin(), moving.begin() + static_cast<std::ptrdiff_t>(n),
                                 [](double rate) { return rate == 0; });
  if (rests && step_straight({to.data(), n}, {most.data(), n}, next)) return true;
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

Twist JogGenerator::twist_now() const noexcept {
  std::array<double, kMostJogJoints> v{};
  for (std::size_t j = 0; j < axes_.size(); ++j) v[j] = state_[j].velocity;
  return solver_.twist_of({v.data(), axes_.size()});
}

void JogGenerator::setpoint_tcp(const JogSetpoint& wish, const JogLimits& limits, JogValues& rates) noexcept {
  if (!lead_.on()) lead_.begin(tcp(), twist_now());
  Twist wanted = wish.kind == JogSetpoint::Kind::tcp_velocity ? wish.twist : Twist{};
  if (wanted != asked_) solver_.forget();
  asked_ = wanted;
  if (wish.tool_frame) wanted = turned(tcp().rotation, wanted);
  const double over =
      std::max(linear(wanted) / (kBelow * limits.tcp_speed), angular(wanted) / (kBelow * limits.tcp_turning));
  if (over > 1) {
    for (double& x : wanted) x /= over;
    note(JogHold::speed, 0);
  }
  if (wish.kind == JogSetpoint::Kind::tcp_target ||
      (wish.kind == JogSetpoint::Kind::tcp_velocity && slide_tcp(wanted)))
    line_.end();
  else if (setpoint_on_line(wish, wanted, limits, rates))
    return;
  const TcpLead::Target target = target_of(wish, limits);
  if (wish.kind == JogSetpoint::Kind::tcp_target) wanted = lead_.way_to(target);
  std::array<double, kMostJogJoints> velocity;
  for (std::size_t j = 0; j < axes_.size(); ++j)
    velocity[j] = std::min(limits.joint_share * velocity_[j], kQuickly * acceleration_[j]);
  const std::span<const double> fast{velocity.data(), axes_.size()};

  // The feasible part of the twist, with foresight: the lead aims for it.
  TwistSolver::Solution solution;
  solver_.solve(wanted, {fast, gentle_acceleration_, gentle_jerk_, lower_, upper_}, solution);
  // Redundant joints near a limit are left out.
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
  if (wish.kind == JogSetpoint::Kind::tcp_target) {
    arrived_ = lead_.approach(target, much, solver_);
  } else {
    for (double& x : wanted) x *= much;
    lead_.ramp(wanted, solver_);
  }

  // The joint velocities for the lead.
  Twist twist = lead_.twist();
  const Twist error = between(tcp(), lead_.pose());
  if (linear(error) > kAstray || angular(error) > kAstray / length_)
    lead_.return_to(tcp());  // continues from the present pose
  else
    for (std::size_t k = 0; k < 6; ++k) twist[k] += kReturn * error[k];
  solver_.solve(twist, {fast, acceleration_, jerk_, lower_, upper_}, solution);
  rates = solution.rates;
  const double share = solution.share * throttle(limits, kFirmly, true, rates);
  if (share < 1 || solution.outcome != TwistOutcome::exact || solver_.columns() < 6)
    lead_.hold_back(tcp(), share);
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

/// Slows `rates` down so that everything can stop in time on the path, and below the speed limits.
/// `common`: also before joint limits. Returns the remaining share.
double JogGenerator::throttle(const JogLimits& limits, Before before, bool common,
                              JogValues& rates) noexcept {
  double share = 1, most = 1e-9;
  for (std::size_t j = 0; j < axes_.size(); ++j) most = std::max(most, std::abs(rates[j]) / axes_[j].velocity);
  const auto [a, jerk] = pull_of({rates.data(), axes_.size()}, before);
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
  const JogValues q = positions();
  Limit limit;
  for (std::size_t i = 0; i < near_limits(); ++i)
    if (find_limit(i, q, limit))
      slow(share_before(limit, {rates.data(), axes_.size()}, a, jerk), limit.hold, limit.which);
  const double speed = linear(solver_.twist_of({rates.data(), axes_.size()}));
  if (speed >= 1e-9) slow(kBelow * limits.tcp_speed / speed, JogHold::speed, 0);
  for (double& r : rates) r *= share;
  return share;
}

void JogGenerator::follow(const JogValues& rates, const JogLimits& limits, States& next) noexcept {
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    AxisLimits own = limits_of(j, limits);
    double slope = 0;
    if (rates_hold_) slope = (rates[j] - rates_[j]) / dt_;
    slope = std::clamp(slope, -0.8 * own.acceleration, 0.8 * own.acceleration);
    if (!lead_.on()) own.acceleration *= kSoft, own.jerk *= kSoft;
    next[j] = towards_velocity(state_[j], rates[j], slope, own, dt_);
  }
}

/// The prediction while every joint brakes: the smallest distance from each boundary that counts, and the
/// speed of the TCP.
struct JogGenerator::Ahead {
  std::array<double, moves::Workspace::kMostBoundaries> distance;
  std::array<double, Barriers::kMost + 1> room;
  double speed = 0, at_once = 0;  // speed: the highest; at_once: at the start
};

void JogGenerator::look_ahead(const States& from, bool looks_at_tcp, Ahead& out) noexcept {
  constexpr std::size_t kEach = 4;  // barriers are looked at in each fourth place
  const std::size_t n = axes_.size();
  std::array<double, kMostJogJoints> q{}, soon{};
  double duration = 0;
  for (std::size_t j = 0; j < n; ++j)
    duration = std::max(duration, AxisBrake(from[j], axes_[j].acceleration, axes_[j].jerk).duration());
  out.speed = out.at_once = 0;
  out.distance.fill(1e300);
  out.room.fill(1e300);
  for (std::size_t k = 0; k <= kPlaces + n; ++k) {
    const double part = static_cast<double>(std::min(k, kPlaces)) / kPlaces;
    double t = duration * part * part;  // denser samples at high speed
    if (k > kPlaces) {                  // and one where each joint is fastest
      const AxisState& s = from[k - kPlaces - 1];
      if (s.acceleration * s.velocity <= 0) continue;
      t = std::abs(s.acceleration) / axes_[k - kPlaces - 1].jerk;
    }
    for (std::size_t j = 0; j < n; ++j) {
      const AxisState s = AxisBrake(from[j], axes_[j].acceleration, axes_[j].jerk).at(t);
      q[j] = s.position;
      soon[j] = s.position + kMoment * s.velocity;
    }
    if (barriers_ && (k % kEach == 0 || k >= kPlaces))
      for (std::size_t i = 0; i <= barriers_->count; ++i)
        out.room[i] = std::min(out.room[i], barriers_->room(i, {q.data(), n}));
    if (!looks_at_tcp) continue;
    const Pose at = chain_.forward({q.data(), n});
    for (std::size_t i = 0; i < workspace_.boundaries(); ++i)
      if (workspace_.counts(i, reduced_))
        out.distance[i] = std::min(out.distance[i], workspace_.distance(i, at, {q.data(), n}).distance);
    out.speed = std::max(out.speed, norm(chain_.forward({soon.data(), n}).position - at.position) / kMoment);
    if (k == 0) out.at_once = out.speed;
  }
}

/// The final check: from the end of this step everything can still stop.
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
  const bool any_speed = limits.tcp_speed < 1e3 || lead_.on();
  const double stray =
      lead_.on() ? kStray + kFaster * std::max(linear(asked_), linear(lead_.twist())) : limits.tcp_speed;
  const bool looks_at_tcp = any_speed || !workspace_.empty();
  if (!looks_at_tcp && !barriers_) return;
  Ahead now, then;  // for braking from now on, which cannot be avoided
  look_ahead(braked, looks_at_tcp, now);
  std::array<double, kMostJogJoints> q{};
  for (std::size_t j = 0; j < n; ++j) q[j] = state_[j].position;
  const Pose place = chain_.forward({q.data(), n});
  std::size_t worst = 0;
  std::int32_t near_body = -1;  // that a barrier belongs to
  const auto reachable = [&](const States& states) {
    for (std::size_t j = 0; j < n; ++j)
      if (!AxisGuard(state_[j], limits_of(j, limits), dt_).safe(states[j])) return false;
    return true;
  };
  const auto safe = [&](const States& states) {
    look_ahead(states, looks_at_tcp, then);
    for (std::size_t i = 0; i < workspace_.boundaries(); ++i) {
      // If the TCP comes too near even while braking, it must brake or move away.
      const bool near = now.distance[i] < kKeepFreeAtLeast;
      const double least = near ? workspace_.distance(i, place, {q.data(), n}).distance : kKeepFreeAtLeast;
      worst = i;
      if (then.distance[i] < std::min(kKeepFreeAtLeast, least) - 1e-12) return false;
    }
    worst = workspace_.boundaries();
    for (std::size_t i = 0; barriers_ && i <= barriers_->count; ++i) {
      // If it is too near even while braking, it may move along, or away: hardly deeper than kBeside, as what
      // one cycle takes adds up.
      double least = 0;
      if (now.room[i] < 0) {
        const double here = barriers_->room(i, {q.data(), n});
        least = std::min(0.0, std::max(here - kBeside, std::min(here - kDeeperInACycle, -kBeside)));
      }
      near_body = barriers_->which(i);
      if (then.room[i] < least - 1e-12) return false;
    }
    near_body = -1;
    // If the TCP is too fast even while braking, it must brake; a small excess in each step would add up.
    return !any_speed || (std::max(then.speed, now.speed) <= kAtMost * limits.tcp_speed &&
                          then.at_once <= std::max(stray, now.at_once) + 1e-12);
  };
  if (safe(next)) return;
  if (worst < workspace_.boundaries())
    note(JogHold::workspace, workspace_.zone_of(worst));
  else if (near_body >= 0)
    note(JogHold::body, static_cast<std::size_t>(near_body));
  else
    note(JogHold::speed, 0);
  // On a line it brakes on it if that is enough.
  States slower = braked, mix;
  const JogValues planned = rates_;
  const bool on_line = brake_on_line(limits, mix) && reachable(mix);
  const bool stays_on_line = on_line && safe(mix);
  if (stays_on_line)
    slower = mix;
  else if (on_line)
    next = mix;
  double low = 0, high = 1;
  const auto set = [&](double share) {
    for (std::size_t j = 0; j < n; ++j) mix[j] = mixed(slower[j], next[j], share);
  };
  for (int i = 0; i < kHalvings; ++i) {
    set((low + high) / 2);
    (safe(mix) ? low : high) = (low + high) / 2;
  }
  set(low);
  next = mix;
  if (!stays_on_line) return;
  line_.take_back(low);
  for (std::size_t j = 0; j < n; ++j) rates_[j] += low * (planned[j] - rates_[j]);
}

// --- a cycle ----------------------------------------------------------------------------------------------

void JogGenerator::step(const JogSetpoint& wish, const JogLimits& limits) noexcept {
  using Kind = JogSetpoint::Kind;
  const std::size_t n = axes_.size();
  hold_ = JogHold::none;
  which_ = -1;
  arrived_ = false;
  reduced_ = limits.reduced;
  if (wish.kind == Kind::rest && standing()) {
    lead_.end();
    rates_hold_ = false;
    kind_ = Kind::rest;
    tcp_speed_ = 0;
    return;
  }
  const auto of_tcp = [](Kind kind) { return kind == Kind::tcp_velocity || kind == Kind::tcp_target; };
  if (!of_tcp(wish.kind) && (wish.kind != Kind::rest || wish.at_once)) lead_.end();
  if (!lead_.on()) line_.end();
  if (wish.kind != kind_ && !(wish.kind == Kind::rest && lead_.on())) rates_hold_ = false;
  if (wish.kind == Kind::joint_velocity && wish.joints != wanted_) rates_hold_ = false;
  kind_ = wish.kind;
  wanted_ = wish.joints;

  for (std::size_t j = 0; j < n; ++j)
    soon_[j] = state_[j].position + dt_ * (state_[j].velocity + dt_ / 2 * state_[j].acceleration);
  solver_.at({soon_.data(), n});
  JogValues rates{};
  States next{};
  bool planned = false;
  if (wish.kind == Kind::joint_velocity) {
    setpoint_joints(wish, limits, rates);
    slide_joints(rates);
    throttle(limits, kFirmly, false, rates);
  } else if (wish.kind == Kind::joint_target) {
    planned = step_to_joints(wish, limits, next);
  } else if (of_tcp(wish.kind) || lead_.on()) {
    setpoint_tcp(wish, limits, rates);
    if (wish.kind == Kind::rest && is_zero(lead_.twist())) lead_.end(), rates_hold_ = false;
    if (wish.kind == Kind::rest) {
      hold_ = JogHold::none;
      which_ = -1;
      if (!lead_.on()) rates = {};
    }
  }
  if (wish.kind == Kind::rest && wish.at_once)
    for (std::size_t j = 0; j < n; ++j)
      next[j] = AxisBrake(state_[j], axes_[j].acceleration, axes_[j].jerk).at(dt_);
  else if (!planned)
    follow(rates, limits, next);
  rates_before_ = rates_;
  rates_ = rates;
  guard(limits, next);
  rates_hold_ = !planned && !(wish.kind == Kind::rest && !lead_.on());
  std::array<double, kMostJogJoints> velocity{};
  for (std::size_t j = 0; j < n; ++j) {
    state_[j] = next[j];
    velocity[j] = next[j].velocity;
  }
  tcp_speed_ = linear(solver_.twist_of({velocity.data(), n}));
}

}  // namespace polyarm::jog
