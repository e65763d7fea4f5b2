/// What a link does while it is open: the thread that answers states and takes replies.
#include "drivers/franka/link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>

#include "drivers/franka/errors.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::franka {

namespace {

constexpr double kPeriod = 0.001;
constexpr Nanoseconds kLook = 20'000'000;    // between two judgements without an event
constexpr Nanoseconds kShare = 600'000;      // of a cycle, for the loop's command; then the driver brakes
constexpr Nanoseconds kEnd = 3'000'000'000;  // for a motion to end
constexpr Nanoseconds kQuiet = 300'000'000;  // without a state, while it ends
constexpr int kPuzzled = 200;                // states until a motion that ended without a reply counts
constexpr double kAhead = 0.01;              // s, for which a limit of velocity must hold
constexpr double kSlowest = 0.02;            // rad/s, that is allowed at the end of a range
constexpr double kFade = 0.1;                // rad of travel in which an offset loses 63 % of itself
constexpr double kStill = 0.005;             // rad/s, measured
constexpr double kStopCycles = 3;            // until a stop begins
constexpr std::size_t kMostReplies = 16;
constexpr std::uint64_t kJudged = 200;  // answers until the share of those in time counts

}  // namespace

void Link::command(bool move, const Seven& joints) noexcept {
  commands_.write({move, samples_.value().sequence, joints});
  wake();
}

void Link::wait(Nanoseconds now) {
  pollfd polled[3] = {{wake_.number(), POLLIN, 0},
                      {states_.number(), POLLIN, 0},
                      {port_lost_ ? -1 : port_.descriptor(), POLLIN, 0}};
  const bool answers = phase_ == Phase::streaming && commanded_ && is_open() && !settings_.stepped;
  const Nanoseconds left = answers ? std::clamp<Nanoseconds>(heard_ + kShare - now, 0, kLook) : kLook;
  const timespec time{0, static_cast<long>(left)};
  ::ppoll(polled, 3, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait(realtime::monotonic_now());
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (renew_) begin_session(now);
    take_replies();
    take_states(now);
    take_command(now);
    judge(now);
    end(now);
  }
}

/// Forgets an earlier motion.
void Link::begin_session(Nanoseconds now) {
  commanded_ = late_ = anchored_ = false;
  puzzled_ = 0;
  answers_ = 0;
  commanded_at_ = now;
  current_.behind = 0;
  current_.shaped = 0;
  stands_ = over_ = false;
  const std::lock_guard lock(mutex_);
  motion_.reset();
  motion_reply_.reset();
  renewed();
}

// --- replies ----------------------------------------------------------------------------------------------

void Link::take_replies() {
  if (port_lost_) return;
  port_lost_ = !port_.receive();
  while (auto frame = port_.next()) {
    if (frame->data.empty()) return note(Cause::bad_data);
    const std::lock_guard lock(mutex_);
    if (motion_ && frame->id == *motion_) {
      motion_reply_ = status_of(frame->data[0], Request::move, version_);
      if (*motion_reply_ != Status::started) motion_.reset();
    } else if (replies_.size() < kMostReplies) {
      replies_[frame->id] = std::move(*frame);
    }
    changed_.notify_all();
  }
  if (port_lost_ && !fault_) note(port_.failure().cause);
}

// --- states -----------------------------------------------------------------------------------------------

/// The first sender at the robot's address is the robot.
bool Link::is_robot(const wire::UdpAddress& from) {
  if (from.host == robot_host_ && (!pinned_ || from == sender_)) {
    sender_ = from;
    pinned_ = true;
    return true;
  }
  if (++current_.strangers == 1) {
    const std::lock_guard lock(mutex_);
    stranger_ = wire::host_text(from);
  }
  return false;
}

/// One state at a time: commands are looked at between two of them.
void Link::take_states(Nanoseconds now) {
  std::array<std::uint8_t, 2500> bytes;
  wire::UdpAddress from;
  const wire::Received got = wire::receive_datagram(states_.number(), bytes, &from);
  if (got.got != wire::Got::bytes || !is_robot(from)) return;
  const auto state = decode_state(Bytes(bytes).first(got.count), version_);
  if (!state) return note(Cause::bad_data);
  take_state(*state, now);
}

void Link::take_state(const RobotState& state, Nanoseconds now) {
  heard_ = now;
  if (current_.sequence > 0 && state.id <= current_.sequence) {  // it came twice, or behind a later one
    ++current_.repeated;
    return samples_.write(current_);
  }
  if (current_.sequence > 0) current_.lost += state.id - current_.sequence - 1;
  // The loop's first command counts if it came before this state. Looked at before the loop sees the state,
  // so that a run repeats itself.
  if (phase_ == Phase::streaming && !brakes() && !commanded_) commanded_ = commands_.fetch();
  current_.state = state;
  current_.q = state.q;
  current_.sequence = state.id;
  samples_.write(current_);
  mode_ = state.mode;
  {
    const std::lock_guard lock(mutex_);
    errors_ = state.errors | state.reflex;
    states_seen_ = state.id;
    changed_.notify_all();
  }
  if (phase_ == Phase::streaming || phase_ == Phase::ending) judge_motion();
  begin_cycle();
  answer(now);
}

/// The robot ended the motion: its mode or its reply says so.
void Link::judge_motion() {
  if (over_) return;
  std::optional<Status> reply;
  {
    const std::lock_guard lock(mutex_);
    reply = motion_reply_;
  }
  const bool ended = reply && *reply != Status::started;
  if (moves() && !ended) return void(puzzled_ = 0);
  if (phase_ == Phase::ending) return void(over_ = !moves());  // as it was asked to, or for a known reason
  explain_end();
}

/// The mode says most; the reply says more than the mode `idle`. They come in any order.
void Link::explain_end() {
  ++puzzled_;
  const bool sure = puzzled_ > kPuzzled;
  switch (current_.state.mode) {
    case RobotMode::reflex:
    case RobotMode::recovery:
      over_ = true;
      return note_errors();
    case RobotMode::user_stopped:
      over_ = true;
      return note(Cause::user_stop);
    case RobotMode::guiding:
      over_ = true;
      return note(Cause::guiding);
    case RobotMode::other:
      over_ = true;
      return note(Cause::locked);
    default:
      break;
  }
  std::optional<Status> reply;
  {
    const std::lock_guard lock(mutex_);
    reply = motion_reply_;
  }
  const bool ended = reply && *reply != Status::started;
  // A reply may overtake the states that show why.
  if (ended && (sure || !moves())) return end_with(*reply);
  if (sure) end_with(Status::unknown);
}

void Link::end_with(Status status) {
  over_ = true;
  if (status == Status::reflex) return note_errors();
  if (status == Status::user_stop) return note(Cause::user_stop);
  if (status == Status::preempted_by_safety || status == Status::refused_by_safety)
    return note(Cause::safety);
  if (!fault_) note(Cause::motion_ended, static_cast<int>(status));
}

void Link::note_errors() {
  const RobotState& state = current_.state;
  const ErrorFlags flags = state.reflex.any() ? state.reflex : state.errors;
  const int first = first_error(flags);
  if (!fault_) note(error_facts(first).cause, first, error_names(flags));
}

// --- commands ---------------------------------------------------------------------------------------------

/// Until the loop commands, the robot is held where its controller has it. Later the loop's answer goes out
/// when it comes.
void Link::answer(Nanoseconds now) {
  if (!moves() || over_) return;
  const Phase phase = phase_;  // another thread may change it
  if (phase == Phase::starting) {
    shaper_.begin(current_.state.q_d);
    velocities_.begin();
    send(by_velocity() ? velocities_.at() : shaper_.at());
    if (renew_) return;
    commands_.fetch();  // drops a command from before the start
    commanded_at_ = now;
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::starting) return;  // stop() gave the start up meanwhile
    phase_ = Phase::streaming;
    return changed_.notify_all();
  }
  if (phase == Phase::idle) return;
  if (brakes()) return brake();
  if (!commanded_) return hold();
  if (!settings_.follows) go_on();
}

void Link::hold() {
  send(by_velocity() ? velocities_.at() : shaper_.at());
}

/// A step of a stop; at rest the motion is ended if the session is.
void Link::brake() {
  fit_limits(last_);
  anchored_ = false;
  if (shaper_still()) return send(by_velocity() ? velocities_.at() : shaper_.at(), brakes());
  send(by_velocity() ? velocities_.brake(limits_) : shaper_.brake(limits_));
}

void Link::send(const Seven& joints, bool finished) {
  RobotCommand out;
  out.id = current_.sequence;
  (by_velocity() ? out.dq : out.q) = joints;
  out.finished = finished;
  std::array<std::uint8_t, kMostCommand> bytes;
  encode(out, version_, bytes);
  wire::send_datagram(states_.number(), Bytes(bytes).first(command_bytes(version_)), sender_);
  answered_ = current_.sequence;
  ++answers_;
}

/// The controller's own position is a little away from the measured one, as the arm yields. The difference at
/// the first command is kept, so that nothing moves, and fades away while the joint moves.
Seven Link::target_of(const Wanted& wanted) noexcept {
  if (by_velocity()) return wanted.joints;
  Seven out = wanted.joints;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (anchored_)
      offset_[i] *= std::max(0.0, 1 - std::abs(wanted.joints[i] - last_[i]) / kFade);
    else
      offset_[i] = shaper_.at()[i] - wanted.joints[i];
    out[i] += offset_[i];
  }
  last_ = wanted.joints;
  anchored_ = true;
  return out;
}

/// The robot's limits of velocity depend on position and direction.
void Link::fit_limits(const Seven& wanted) noexcept {
  auto& velocity = limits_.of[0];
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    const double q = by_velocity() ? current_.state.q_d[i] : shaper_.at()[i];
    const double v = by_velocity() ? velocities_.at()[i] : shaper_.velocity()[i];
    const VelocityBounds bounds = velocity_bounds(version_, i, q + v * kAhead);
    const bool up = by_velocity() ? wanted[i] >= 0 : wanted[i] >= q;
    const double most = up ? bounds.upper : -bounds.lower;
    velocity[i] = std::min(settings_.limits.of[0][i], std::max(most, kSlowest));
  }
}

/// The way of a stop from a speed, rad.
double Link::stopping_way(std::size_t joint, double velocity) const noexcept {
  return wire::stopping_way(velocity, limits_.at(wire::LimitKind::acceleration, joint),
                            limits_.at(wire::LimitKind::jerk, joint), kStopCycles * kPeriod);
}

/// What the robot would raise a reflex for is not sent: the robot comes to rest before it.
bool Link::allowed(const Seven& wanted) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!(settings_.lower[i] < settings_.upper[i])) continue;
    const double v = by_velocity() ? velocities_.at()[i] : shaper_.velocity()[i];
    const double at =
        (by_velocity() ? current_.state.q_d[i] : wanted[i]) + std::copysign(stopping_way(i, v), v);
    const bool out = (at > settings_.upper[i] && v > 0) || (at < settings_.lower[i] && v < 0);
    if (!out) continue;
    note(Cause::position_limit, static_cast<int>(i));
    return false;
  }
  return true;
}

/// The next step towards what the loop wants.
void Link::go_on() {
  const Wanted& wanted = commands_.value();
  if (!wanted.move) return brake();
  const Seven target = target_of(wanted);
  fit_limits(target);
  if (!allowed(target)) return brake();
  if (by_velocity()) {
    send(velocities_.next(target, limits_));
    current_.shaped = velocities_.shaped();
    return;
  }
  send(shaper_.next(target, limits_));
  current_.behind = shaper_.behind();
  current_.shaped = shaper_.shaped();
  late_ = late_ && current_.behind > 0;
  judge_behind(shaper_, current_.behind, settings_.most_behind, late_ ? Cause::loop_silent : Cause::none);
}

/// A command answers the state that the loop had read. If it does not come within its share of the cycle, a
/// step of a stop goes out instead: the robot counts missing answers.
void Link::take_command(Nanoseconds now) {
  const bool fresh = commands_.fetch();
  if (fresh || !commanded_) commanded_at_ = now;
  if (phase_ != Phase::streaming) return;
  commanded_ = commanded_ || fresh;
  if (!commanded_ || !settings_.follows || !is_open() || !moves() || over_) return;
  if (brakes()) return brake();  // the loop does not answer any more
  if (commands_.value().id == current_.sequence) return go_on();
  if (settings_.stepped || now - heard_ < kShare) return;
  late_ = late_ || current_.behind == 0;
  const bool anchored = anchored_;
  brake();
  anchored_ = anchored;  // the loop goes on with its path
}

// --- judgement --------------------------------------------------------------------------------------------

void Link::judge(Nanoseconds now) {
  if (fault_) return;
  if (states_seen_ > 0 && now - heard_ > settings_.silence)
    return note(Cause::silent, 0, own_address_ + ":" + std::to_string(wire::local_port(states_.number())));
  if (phase_ != Phase::streaming || over_) return;
  if (commanded_ && now - commanded_at_ > settings_.loop_silence) return note(Cause::loop_silent);
  if (settings_.least_success <= 0 || answers_ < kJudged) return;
  if (current_.state.success_rate < settings_.least_success)
    note(Cause::low_success, static_cast<int>(std::lround(100 * current_.state.success_rate)));
}

/// Brakes, and waits until the robot stands and the motion has ended.
void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::streaming && fault_) phase_ = Phase::ending;
  if (phase_ != Phase::ending) {
    ending_since_ = now;
    return;
  }
  if (stands_) return;
  if (is_open() && moves() && !over_) brake();  // the loop does not answer any more
  const bool still = std::all_of(current_.state.dq.begin(), current_.state.dq.end(),
                                 [](double v) { return std::abs(v) < kStill; });
  const bool quiet = now - heard_ > kQuiet;
  if (!(over_ && still) && !quiet && now - ending_since_ < kEnd) return;
  stands_ = true;
  changed_.notify_all();
}

}  // namespace polyarm::franka
