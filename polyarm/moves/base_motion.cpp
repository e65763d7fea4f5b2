#include "polyarm/moves/base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace polyarm::moves {

namespace {
using trajectory::MotionLimits;
using trajectory::MotionState;

constexpr double kToFullSpeed = 0.5, kToFullAcceleration = 0.2;  // s, to use if the controller states no
                                                                 // limits
constexpr double kAnySpeed = 1, kAnyTurning = 2;                 // m/s and rad/s, to use in the same case
constexpr double kGain = 2;                                      // 1/s
constexpr double kOfPeriod = 0.1;                                // largest product of gain and period
constexpr double kHere = 1e-3, kHereTurned = 3e-3;               // m and rad: arrived
constexpr double kBack = 2, kSharpest = 0.5;                     // 1/m, of steered bases: curvature per rad
                                                                 // off the line, and its maximum
constexpr double kTimeout = 3;                                   // s after the planned end before the move
                                                                 // fails

constexpr double kSideways = 3, kMostSideways = 0.3;  // 1/m, of ways: rad towards the line per
                                                      // metre beside it, and their maximum
/// So long after its end a move explains the motion of the base: since it stands, because its velocity is
/// measured over some time, and at most, ns.
constexpr Nanoseconds kStandsStill = 150'000'000, kRollsOut = 1'000'000'000;
/// So far it may roll beyond the end of a move or a leg, m and rad, and so long as before until it brakes, s.
constexpr double kRolled = 0.01, kRolledTurn = 0.03, kUntilItBrakes = 0.1;
constexpr double kStrayed = 0.05;                     // m beside its leg: it needs another way
constexpr int kMostWays = 10;                         // of one move

// Ways of steered bases:
constexpr double kOfSteering = 0.85;     // of its largest curvature; the rest steers back to the way
constexpr double kSteered = 0.03;        // of its largest curvature: it has the curvature of the leg
constexpr double kCreep = 1e-6;          // m/s: the base stands and steers
constexpr double kSteeringTimeout = 15;  // s: large steering joints turn slowly
constexpr double kThere = 0.01;          // m beside the goal; farther away it looks for another way
constexpr double kThereTurned = std::numbers::pi / 180;  // rad, the same
constexpr double kSlowest = 0.5, kFastest = 3;           // 1/m: how fast it comes back to its way
constexpr double kDamping = 0.9;

Vec3 ahead_of(const Pose& pose) {
  return pose.rotation * Vec3{1, 0, 0};
}

double heading_of(const Pose& pose) {
  const Vec3 ahead = ahead_of(pose);
  return std::atan2(ahead.y, ahead.x);
}

double stated(double value, double fallback) {
  return std::isfinite(value) && value > 0 ? value : fallback;
}
}  // namespace

BaseMotion::BaseMotion(controllers::BaseController& controller, double period)
    : controller_(controller),
      odometry_(controller.odometry_output()),
      gain_(std::min(kGain, kOfPeriod / std::max(period, 1e-6))) {}

BaseMotion::~BaseMotion() {
  drop_search();
}

double BaseMotion::sharpest() const {
  return kOfSteering * controller_.sharpest();
}

std::uint64_t BaseMotion::start(const BaseMove& move) {
  if (active_) throw Error("busy", "the base is moving already", "one move of a base at a time");
  if (!odometry_) throw Error("no-odometry", "the base's controller publishes no odometry");
  if (move.turns && !controller_.turns_on_the_spot())
    throw Error("bad-move", "this base steers: it cannot turn on the spot",
                "drive it, or send twists to its controller");
  move_ = move;
  active_ = true;
  planned_ = seen_ = leg_begun_ = goes_on_ = false;
  late_ = unheard_ = 0;
  last_ = -1;
  ways_ = 0;
  problem_.reset();
  drop_search();
  way_.reset();
  if (!move.to) begin(move.turns, move.amount, 0);
  return ++last_id_;
}

/// Sets the limits of a turn, a line or an arc.
void BaseMotion::begin(bool turns, double amount, double curvature) {
  turns_ = turns, amount_ = amount, curvature_ = curvature;
  const controllers::SpeedLimits own = turns ? controller_.angular_limits() : controller_.linear_limits();
  double speed = stated(own.max_velocity, turns ? kAnyTurning : kAnySpeed);
  if (amount < 0 && !turns) speed = stated(-own.min_velocity, speed);
  const double most = stated(own.max_acceleration, speed / kToFullSpeed);
  double acceleration = std::min(most, stated(-own.max_deceleration, most));
  double jerk = stated(own.max_jerk, acceleration / kToFullAcceleration);
  const bool of_way = move_.to && turns;
  const double asked_speed = of_way ? move_.turn_speed : move_.speed;
  const double asked_acceleration = of_way ? move_.turn_acceleration : move_.acceleration;
  speed *= move_.share;
  if (asked_speed > 0) speed = std::min(speed, asked_speed);
  if (curvature != 0) {
    const double share = controller_.share_on(curvature);  // the limits are those of the fastest wheel
    speed *= share, acceleration *= share, jerk *= share;
    if (move_.turn_speed > 0) speed = std::min(speed, move_.turn_speed / std::abs(curvature));
  }
  if (asked_acceleration > 0) acceleration = std::min(acceleration, asked_acceleration);
  limits_ = MotionLimits::symmetric(speed, acceleration, jerk);
  planned_ = steered_ = false;
  late_ = steering_ = 0;
  most_ = std::numeric_limits<double>::infinity();
}

Pose BaseMotion::pose() {
  if (!odometry_) return around_.T_world_odometry();
  odometry_->fetch();
  const controllers::Output::Sample& sample = odometry_->value();
  if (sample.time == 0 || sample.values.size() < 7) return around_.T_world_odometry();  // it begins at zero
  const std::vector<double>& v = sample.values;
  return around_.T_world_odometry() * Pose{{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
}

/// False while the base has no turn or line to do.
bool BaseMotion::has_leg() {
  if (!move_.to) return true;
  if (!way_ && !take_way()) return false;
  if (!leg_begun_ && (controller_.standing() || goes_on_)) begin_leg();
  return active_ && leg_begun_;
}

void BaseMotion::begin_search() {
  job_ = std::make_shared<Job>();
  around_.post([job = job_, search = around_.look(*move_.to)] {
    try {
      job->legs = search([&] { return job->dropped.load(std::memory_order_relaxed); });
    } catch (const Error& e) {
      job->failure = e.problems().front();
    } catch (const std::exception& e) {
      job->failure = Problem{"no-way", {}, std::string("the way could not be planned: ") + e.what(), {}};
    }
    job->done.store(true, std::memory_order_release);
  });
}

/// A search that nobody waits for any longer ends soon: other moves wait for the planning thread.
void BaseMotion::drop_search() {
  if (job_) job_->dropped.store(true, std::memory_order_relaxed);
  job_.reset();
}

/// Begins the search where the base stands; true once the way is known.
bool BaseMotion::take_way() {
  if (!job_ && controller_.standing()) begin_search();
  if (!job_ || !job_->done.load(std::memory_order_acquire)) return false;
  const std::shared_ptr<Job> job = std::exchange(job_, nullptr);
  if (job->failure || ++ways_ > kMostWays) {
    fail(job->failure.value_or(Problem{
        "base-short", {}, "the base does not stay on its way", "is it blocked, or do its wheels slip?"}));
    return false;
  }
  way_ = std::move(job->legs);
  // The heading is put right at the end.
  if (!steers()) {
    const double kept = way_->empty() ? 0 : way_->back().kept;
    way_->push_back({true, move_.to->position, move_.to->position, heading_of(*move_.to), false, 0, 0, kept});
  }
  leg_ = 0, leg_begun_ = false;
  return true;
}

void BaseMotion::fail(Problem problem) {
  problem_ = std::move(problem);
  end(State::failed);
}

/// The next leg, from where the base stands. A turn that is smaller than what counts as arrived is left out.
void BaseMotion::begin_leg() {
  const Pose T_odometry_world = inverse(around_.T_world_odometry());
  for (; leg_ < way_->size(); ++leg_) {
    const BaseLeg& leg = (*way_)[leg_];
    const double length = leg.backwards ? -leg.length : leg.length;
    const double heading = leg.heading + heading_of(T_odometry_world) - leg.curvature * length;
    const double turn = std::remainder(heading - place_.heading, 2 * std::numbers::pi);
    if (leg.turns && std::abs(turn) < kHereTurned) continue;
    const Vec3 from = T_odometry_world * leg.from;
    begin_ = Place{from.x, from.y, place_.heading + (leg.turns ? 0 : turn)};
    begin(leg.turns, leg.turns ? turn : length, leg.curvature);
    leg_begun_ = true;
    return;
  }
  end_way();
}

/// For another way, from where the base comes to rest.
void BaseMotion::look_again() {
  way_.reset();
  leg_begun_ = goes_on_ = false;
  send(0, 0);
}

/// A base that steers and is beside its goal looks for a way to it from there.
void BaseMotion::end_way() {
  if (!steers()) return end(State::done);
  const Pose now = pose();
  const double off = std::hypot(now.position.x - move_.to->position.x, now.position.y - move_.to->position.y);
  const double turned = std::remainder(heading_of(now) - heading_of(*move_.to), 2 * std::numbers::pi);
  if (off < kThere && std::abs(turned) < kThereTurned) return end(State::done);
  look_again();
}

/// The present turn or line has ended. True if the move has another leg.
bool BaseMotion::go_on() {
  if (!move_.to) return false;
  ++leg_;
  leg_begun_ = planned_ = false;
  goes_on_ = steers();
  if (!goes_on_) send(0, 0);
  begin_to_roll();
  return true;
}

/// Reads the odometry; headings continue beyond half a turn.
bool BaseMotion::look() {
  odometry_->fetch();
  const controllers::Output::Sample& sample = odometry_->value();
  if (sample.time == 0 || sample.values.size() < 7) return false;
  const double heading = 2 * std::atan2(sample.values[5], sample.values[6]);
  Place now{sample.values[0], sample.values[1], heading};
  if (seen_) now.heading = place_.heading + std::remainder(heading - place_.heading, 2 * std::numbers::pi);
  place_ = now;
  if (!seen_) begin_ = now;
  seen_ = true;
  return true;
}

/// True if the controller has published nothing for too long: it was not configured, or it is not active.
bool BaseMotion::is_silent(double dt) {
  const Nanoseconds stamp = odometry_->value().time;
  unheard_ = std::exchange(heard_, stamp) == stamp ? unheard_ + dt : 0;
  return unheard_ > kTimeout;
}

double BaseMotion::covered() const {
  const double turned = place_.heading - begin_.heading;
  if (turns_) return turned;
  const double x = place_.x - begin_.x, y = place_.y - begin_.y;
  const double c = std::cos(begin_.heading), s = std::sin(begin_.heading);
  if (curvature_ == 0) return x * c + y * s;
  // The angle about the centre of the arc, by the turn that is nearest to that of the base.
  const double side = curvature_ * (y * c - x * s), ahead = curvature_ * (x * c + y * s);
  const double angle = std::atan2(ahead, 1 - side);
  return (turned + std::remainder(angle - turned, 2 * std::numbers::pi)) / curvature_;
}

/// How far the base is to the left of its line or arc.
double BaseMotion::beside() const {
  const double x = place_.x - begin_.x, y = place_.y - begin_.y;
  const double c = std::cos(begin_.heading), s = std::sin(begin_.heading);
  const double ahead = x * c + y * s, side = y * c - x * s;
  if (curvature_ == 0) return side;
  return (1 - std::hypot(curvature_ * ahead, 1 - curvature_ * side)) / curvature_;
}

/// How far the base is from the line, or from the place of the turn.
double BaseMotion::strayed() const {
  if (turns_) return std::hypot(place_.x - begin_.x, place_.y - begin_.y);
  const double done = covered();
  return std::hypot(done - std::clamp(done, std::min(amount_, 0.0), std::max(amount_, 0.0)), beside());
}

/// The base brakes now. It rolls no farther than its speed explains.
void BaseMotion::begin_to_roll() {
  const std::vector<double>& v = odometry_->value().values;
  const bool known = odometry_->value().time != 0 && v.size() >= 13;
  const auto rolls = [](double speed, const controllers::SpeedLimits& limits, double any) {
    const double braking = stated(-limits.max_deceleration, stated(limits.max_acceleration, any));
    return std::abs(speed) * (kUntilItBrakes + std::abs(speed) / (2 * braking));
  };
  RollOut roll{now_, place_, kRolled, kRolledTurn, {}};
  if (known) {
    roll.way += rolls(v[7], controller_.linear_limits(), kAnySpeed / kToFullSpeed);
    roll.turn += rolls(v[12], controller_.angular_limits(), kAnyTurning / kToFullSpeed);
  }
  rolls_out_ = roll;
}

/// Motion after the base has stood, or farther than it rolls, has another cause than the move.
void BaseMotion::follow_roll(Nanoseconds now) {
  if (!rolls_out_ || !look()) return;
  RollOut& roll = *rolls_out_;
  const bool stands = controller_.standing();
  if (stands && !roll.stood) roll.stood = now;
  const double turned = std::remainder(place_.heading - roll.from.heading, 2 * std::numbers::pi);
  const bool is_other = (roll.stood && !stands) || std::abs(turned) > roll.turn ||
                        std::hypot(place_.x - roll.from.x, place_.y - roll.from.y) > roll.way;
  const bool is_over = now - roll.since > kRollsOut || (roll.stood && now - *roll.stood > kStandsStill);
  if (is_other || is_over) rolls_out_.reset();
}

std::optional<BaseMotion::Left> BaseMotion::left() const {
  if (!active_ || !planned_) return rolls_out_ ? std::optional<Left>(Left{}) : std::nullopt;
  const double rest = (amount_ < 0 ? -1 : 1) * (amount_ - covered());
  // Somebody else drives it: the leg does not say where it goes.
  if (rest < (turns_ ? -kRolledTurn : -kRolled) || strayed() > kStrayed) return std::nullopt;
  Left left{.backwards = amount_ < 0, .braking = limits_.max_acceleration};
  if (move_.to && leg_ < way_->size()) left.kept = (*way_)[leg_].kept;
  if (turns_) {
    left.turn = std::max(0.0, rest);
  } else {
    left.way = std::max(0.0, rest);
    left.turn = left.way * std::abs(curvature_), left.curvature = curvature_;
  }
  return left;
}

bool BaseMotion::plan(double from) {
  const std::array<MotionState, 1> start{{{from, 0, 0}}}, target{{{amount_, 0, 0}}};
  const std::array<MotionLimits, 1> limits{limits_};
  trajectory::MotionOptions options;
  if (from == 0 && !move_.to) options.minimum_duration = move_.duration;
  time_ = 0, pace_ = slow_ = 1;
  return motion_.plan(start, target, limits, options) == trajectory::MotionStatus::ok;
}

void BaseMotion::send(double linear, double angular) {
  controllers::Twist twist;
  twist.linear.x = linear;
  twist.angular.z = angular;
  controller_.receive("cmd_vel", twist, false);
}

void BaseMotion::end(State outcome) {
  active_ = false;
  outcome_ = outcome;
  drop_search();
  send(0, 0);
  begin_to_roll();
}

void BaseMotion::tick(Nanoseconds now, bool running, double share) {
  now_ = now;
  follow_roll(now);
  if (!active_ || now == last_) return;
  const double dt = last_ < 0 ? 0 : seconds(now - last_);
  last_ = now;
  const bool seen = look();
  if (!running) {  // the base stops; it continues from there later
    planned_ = steered_ = goes_on_ = false;
    steering_ = 0;
    return;
  }
  if (is_silent(dt)) {
    problem_ =
        Problem{"base-silent",
                {},
                fmt::format("the controller of the base has published no odometry for {:g} s", kTimeout),
                "polyarm control list says whether it is active; the start of the run says why it is not"};
    active_ = false;
    outcome_ = State::failed;
    drop_search();
    return;
  }
  const double rate = std::clamp(share, 0.0, 1.0);
  if (!seen || !has_leg() || (!planned_ && !begin_plan(dt * rate))) return;
  if (steers() && strayed() > kStrayed) return look_again();
  const double done = covered(), most = limits_.max_velocity;
  time_ += dt * rate * pace_ * slow_;
  std::array<MotionState, 1> state;
  motion_.sample(time_, state);
  slow_down(state[0], dt * rate);
  // The command does not include the share: the controller applies it to every command.
  const double asked = slow_ * state[0].velocity + gain_ * (state[0].position - done);
  const double speed = std::clamp(asked, -most, most);
  pace_ = speed == asked ? 1 : most / std::abs(asked);  // the plan's time runs slower while the base lags
                                                        // behind at full speed
  if (time_ >= motion_.duration() && late(amount_ - done, dt * rate)) return;
  send_speed(speed);
}

/// Brings the speed below set_most(), as far as the acceleration that the plan leaves allows.
void BaseMotion::slow_down(const MotionState& state, double dt) {
  const double speed = std::max(std::abs(state.velocity), 1e-6);
  const double wanted = std::min(1.0, most_ / speed);
  // What the plan has of it now, positive while it gets faster.
  const double planned = std::copysign(1, state.velocity) * state.acceleration * slow_ * slow_;
  const double less = std::max(0.0, limits_.max_acceleration + planned);
  const double more = std::max(0.0, limits_.max_acceleration - planned);
  slow_ = std::clamp(wanted, slow_ - dt * less / speed, slow_ + dt * more / speed);
}

/// True once the base may move along its turn, line or arc.
bool BaseMotion::begin_plan(double dt) {
  if (steering_ == 0 && !goes_on_ && !controller_.standing()) return false;
  if (move_.to && strayed() > kStrayed) {  // somebody has moved it: another way
    look_again();
    return false;
  }
  if (steers() && !steered_ && !has_steered(dt)) return false;
  planned_ = active_ && plan(covered());
  if (active_ && !planned_) end(State::failed);
  return planned_;
}

/// Steers at rest to the curvature of the leg.
bool BaseMotion::has_steered(double dt) {
  const double off = std::abs(controller_.curvature() - curvature_);
  // What it measured may be older than the first command.
  steered_ = steering_ > 0 && off < kSteered * controller_.sharpest();
  if (steered_) return true;
  steering_ += dt;
  if (steering_ > kSteeringTimeout) {
    fail({"base-short",
          {},
          fmt::format("the base steers to a curvature of {:.3f} 1/m instead of {:.3f} 1/m",
                      controller_.curvature(), curvature_),
          "is the steering blocked, or are the limits of its joint too small?"});
    return false;
  }
  send_steered(std::copysign(kCreep, amount_), 0);
  return false;
}

/// After the planned end: true if the move, or its leg, has ended.
bool BaseMotion::late(double off, double dt) {
  late_ += dt;
  if (std::abs(off) < (turns_ ? kHereTurned : kHere)) {
    if (!go_on()) end(State::done);
    return true;
  }
  if (late_ <= kTimeout) return false;
  const double done = amount_ - off;
  fail({"base-short",
        {},
        turns_
            ? fmt::format("the base has turned by {:.1f} of {:.1f} deg and does not get further",
                          done * 180 / std::numbers::pi, amount_ * 180 / std::numbers::pi)
            : fmt::format("the base has driven {:.3f} of {:.3f} m and does not get further", done, amount_),
        "is it blocked, or do its wheels slip?"});
  return true;
}

/// Along the turn or the line. On a way the base also steers back to its line.
void BaseMotion::send_speed(double speed) {
  if (turns_) return send(0, speed);
  if (steers()) {
    // Back to the way in a time that fits the steering; on a long wheelbase slower.
    const double rate = std::clamp(controller_.sharpest(), kSlowest, kFastest);
    const double back = std::clamp(rate / (2 * kDamping) * beside(), -kMostSideways, kMostSideways);
    const double astray = begin_.heading + curvature_ * covered() - place_.heading;
    return send_steered(std::abs(speed) < kCreep ? std::copysign(kCreep, amount_) : speed,
                        2 * kDamping * rate * (astray - (amount_ < 0 ? -back : back)));
  }
  double astray = begin_.heading - place_.heading;
  if (move_.to)
    astray -= std::clamp(kSideways * beside(), -kMostSideways, kMostSideways) * (amount_ < 0 ? -1 : 1);
  // A steered base turns in proportion to its speed: the correction is a curvature.
  const double turn = stated(controller_.angular_limits().max_velocity, kAnyTurning) / 4;
  send(speed, controller_.turns_on_the_spot()
                  ? std::clamp(gain_ * astray, -turn, turn)
                  : std::abs(speed) * std::clamp(kBack * astray, -kSharpest, kSharpest));
}

/// `astray`: curvature to add, of the turn per metre of way, ahead or backwards.
void BaseMotion::send_steered(double speed, double astray) {
  const double most = controller_.sharpest();
  send(speed, speed * std::clamp(curvature_ + std::copysign(1, speed) * astray, -most, most));
}

void BaseMotion::drop() {
  if (active_) end(State::discarded);
}

BaseMotion::State BaseMotion::state_of(std::uint64_t id) const {
  if (id == last_id_) return active_ ? State::running : outcome_;
  return State::done;
}

}  // namespace polyarm::moves
