/// What a link does while it is open: the thread that reads states and sends points.
#include "drivers/yaskawa/link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr Nanoseconds kLook = 20'000'000;    // between two judgements without an event
constexpr Nanoseconds kRetry = 4'000'000;    // until a point that found the controller busy goes out again
constexpr Nanoseconds kEnd = 3'000'000'000;  // for a motion to end
constexpr double kStillWay = 1e-4;           // rad between two states of a robot that stands
constexpr double kStillSpeed = 0.01;         // rad/s
constexpr int kRestAfter = 600'000;          // ms of a trajectory: the next rest begins a new one
constexpr int kRest = 500;                   // ms of such a rest
constexpr int kMostTime = 14'000'000;        // ms of a trajectory; MotoROS takes 4 h
constexpr std::size_t kMostPoints = bounds::kMotoPoints;  // that wait for the controller
constexpr int kPointsPerCheck = 10;                       // between two looks at the controller's buffer
constexpr int kMostBrakeCycles = 4000;
constexpr int kHalfMillisecond = 500;  // µs: the controller cuts the time to ms

Ten floats(const Six& degrees) {
  Ten out{};
  for (std::size_t i = 0; i < 6; ++i) out[i] = static_cast<float>(degrees[i] * wire::kRadians);
  return out;
}

Six degrees(const Six& radians) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = radians[i] / wire::kRadians;
  return out;
}

}  // namespace

void Link::command(bool move, const Six& joints) noexcept {
  Wanted wanted{move, {}};
  for (std::size_t i = 0; i < 6; ++i) wanted.joints[i] = joints[i] / wire::kRadians;
  if (!commands_.push(wanted)) return fail(Cause::points_stuck, 0);
  ++pushed_;
  wake();
}

void Link::wait(Nanoseconds) {
  pollfd polled[3] = {{wake_.number(), POLLIN, 0},
                      {state_.descriptor(), POLLIN, 0},
                      {owns_motion() ? motion_.descriptor() : -1, POLLIN, 0}};
  const timespec time{0, static_cast<long>(retry_ ? kRetry : kLook)};
  ::ppoll(polled, 3, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait(realtime::monotonic_now());
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (renew_) begin_streaming();
    take_states(now);
    take_commands(now);
    take_answers(now);
    ask_next(now);
    judge(now);
    end(now);
    ask_next(now);
    note_settled();
  }
}

/// What is left of an earlier session counts no more.
void Link::begin_streaming() {
  for (Wanted dropped; commands_.pop(dropped);) ++taken_;
  stream_ = PointStream(settings_.point_ms, settings_.lead_ms, settings_.cycles);
  asked_ = Asked::nothing;
  begun_ = check_ = braked_ = stopped_ = retry_ = false;
  since_check_ = 0;
  queue_ = -1;
  busy_since_ = 0;
  commanded_at_ = realtime::monotonic_now();
  current_.behind = 0;
  current_.shaped = 0;
  current_.busy = 0;
  stands_ = lost_ = false;
  const std::lock_guard lock(mutex_);
  renew_ = false;
  changed_.notify_all();
}

// --- states -----------------------------------------------------------------------------------------------

void Link::take_states(Nanoseconds now) {
  if (!state_.is_open()) return;
  const bool well = state_.receive();
  while (const auto message = state_.next()) take_state(*message, now);
  if (!well) note(state_.failure().cause);
}

void Link::take_state(const Message& message, Nanoseconds now) {
  if (message.type == MotoType::feedback) {
    const auto feedback = decode_feedback(message, state_.order());
    if (!feedback) return note(Cause::bad_data);
    if (feedback->group != settings_.group) return;
    feedback_ = *feedback;
    fresh_feedback_ = true;
  } else if (message.type == MotoType::robot_status) {
    const auto status = decode_status(message, state_.order());
    if (!status) return note(Cause::bad_data);
    publish(*status, now);
  }
}

/// One state is the positions of the group and the status behind them.
void Link::publish(const MotoStatus& status, Nanoseconds now) {
  if (!fresh_feedback_) return void(++without_feedback_);
  fresh_feedback_ = false;
  const double dt = seconds(now - heard_);
  double way = 0, fastest = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const double q = feedback_.position[i];
    way = std::max(way, std::abs(q - current_.q[i]));
    const bool measured = (feedback_.valid & 4) != 0;
    current_.dq[i] = measured                          ? feedback_.velocity[i]
                     : dt > 0 && current_.sequence > 0 ? (q - current_.q[i]) / dt
                                                       : 0;
    fastest = std::max(fastest, std::abs(current_.dq[i]));
    current_.q[i] = q;
  }
  still_states_ = way < kStillWay && fastest < kStillSpeed ? still_states_ + 1 : 0;
  current_.status = status;
  heard_ = now;
  ++current_.sequence;
  possible_ = status.motion_possible == 1;
  alarm_code_ = status.alarm_code;
  check_ = check_ || (phase_ == Phase::streaming && !possible_);
  retry_ = false;
  samples_.write(current_);
  begin_cycle();
  const std::lock_guard lock(mutex_);
  states_seen_ = current_.sequence;
  changed_.notify_all();
}

// --- commands ---------------------------------------------------------------------------------------------

/// Each command counts: a point is due after so many of them.
void Link::take_commands(Nanoseconds now) {
  for (Wanted wanted; commands_.pop(wanted);) {
    ++taken_;
    if (phase_ != Phase::streaming || fault_) continue;
    commanded_at_ = now;
    if (!begun_) {
      stream_.begin(degrees(current_.q));
      begun_ = true;
    }
    feed(wanted);
  }
}

void Link::feed(const Wanted& wanted) {
  const bool rests = stream_.open() && stream_.time_ms() > kRestAfter && stream_.still_ms() > kRest;
  if (rests) stream_.rest();
  if (wanted.move)
    stream_.go(wanted.joints, settings_.limits);
  else
    stream_.brake(settings_.limits);
  const wire::Shaper& shaper = stream_.shaper();
  current_.behind = shaper.behind() * wire::kRadians;
  current_.shaped = shaper.shaped();
  if (stream_.time_ms() > kMostTime) return note(Cause::too_long);
  if (stream_.out().size() > kMostPoints) return note(Cause::points_stuck);
  if (current_.behind <= settings_.most_behind) return;
  const std::size_t axis = shaper.axis_behind();
  note(Cause::too_fast, static_cast<int>(3 * axis) + static_cast<int>(shaper.exceeded(axis)));
}

// --- requests and answers ---------------------------------------------------------------------------------

void Link::send(std::span<const std::uint8_t> bytes, Asked what, Nanoseconds now) {
  if (!motion_.send(bytes)) {
    lost_ = true;
    return note(motion_.failure().cause);
  }
  asked_ = what;
  asked_at_ = now;
}

void Link::send_point(Nanoseconds now) {
  const TimedPoint& next = stream_.out().front();
  MotoPoint out;
  out.group = settings_.group;
  out.sequence = next.sequence;
  out.time = static_cast<float>((next.time_ms * 1000.0 + kHalfMillisecond) / 1e6);
  out.position = floats(next.position);
  out.velocity = floats(next.velocity);
  send(encode(out, motion_.order()), Asked::point, now);
}

/// One request at a time, as MotoROS answers them.
void Link::ask_next(Nanoseconds now) {
  if (!owns_motion() || lost_ || stopped_ || asked_ != Asked::nothing) return;
  const auto control = [&](MotoCommand command, Asked what) {
    send(encode(MotoControl{settings_.group, ++control_sequence_, command}, motion_.order()), what, now);
  };
  const bool by_time = !settings_.stepped || phase_ == Phase::ending;  // else with the next state
  if (retry_ && by_time && now - asked_at_ >= kRetry) retry_ = false;
  const bool empty = stream_.out().empty();
  const bool begins = !empty && stream_.out().front().sequence == 0;  // only into an empty buffer
  const bool ends = empty && phase_ == Phase::ending && begun_;
  if (check_) return control(MotoCommand::check_ready, Asked::ready);
  if (retry_) return;
  if ((begins || ends) && queue_ != 0) return control(MotoCommand::check_queue, Asked::queue);
  if (since_check_ >= kPointsPerCheck) return control(MotoCommand::check_queue, Asked::queue);
  if (!empty) send_point(now);
}

void Link::take_answers(Nanoseconds now) {
  if (!owns_motion() || lost_) return;
  const bool well = motion_.receive();
  while (const auto message = motion_.next()) {
    const auto reply = decode_reply(*message, motion_.order());
    if (!reply) {
      lost_ = true;
      return note(Cause::bad_data);
    }
    take_answer(*reply);
    ask_next(now);
  }
  if (well) return;
  lost_ = true;
  note(motion_.failure().cause);
}

void Link::take_answer(const MotoReply& reply) {
  const Asked what = std::exchange(asked_, Asked::nothing);
  if (what == Asked::point) return take_point_answer(reply);
  if (what == Asked::queue)
    return take_queue_answer(reply.result == MotoResult::success ? reply.subcode : -1);
  if (what != Asked::ready) return;
  check_ = false;
  if (reply.result == MotoResult::success) return;
  const Why why = why_not(static_cast<int>(MotoResult::not_ready), reply.subcode);
  end_with(why.cause, why.detail);
}

void Link::take_point_answer(const MotoReply& reply) {
  if (reply.result == MotoResult::busy) {
    if (busy_since_ == 0) busy_since_ = asked_at_;
    ++current_.busy;
    retry_ = true;
    return;
  }
  busy_since_ = 0;
  queue_ = -1;
  ++since_check_;
  if (reply.result == MotoResult::success) {
    if (!stream_.out().empty()) stream_.out().pop_front();
    return;
  }
  const Why why = why_not(static_cast<int>(reply.result), reply.subcode);
  end_with(why.cause, why.detail);
}

/// The clocks of two machines differ: intervals become a millisecond longer or shorter while the buffer holds
/// too little or too much.
void Link::take_queue_answer(int count) {
  queue_ = count;
  since_check_ = 0;
  const bool begins = !stream_.out().empty() && stream_.out().front().sequence == 0;
  retry_ = count != 0 && (begins || phase_ == Phase::ending);
  if (count < 0) return;
  current_.buffered_ms = count * settings_.interpolation_ms;
  if (begins || phase_ != Phase::streaming) return;
  const int off = current_.buffered_ms - (settings_.lead_ms - 3 * settings_.point_ms / 2);
  if (std::abs(off) < settings_.lead_ms / 6) stream_.trim(0);
  if (off > settings_.lead_ms / 3) stream_.trim(-1);
  if (off < -settings_.lead_ms / 3) stream_.trim(1);
  const bool moves = phase_ == Phase::streaming && begun_ && !stream_.stands();
  if (count == 0 && moves && stream_.time_ms() > settings_.lead_ms + 10 * settings_.point_ms)
    note(Cause::points_late);
}

/// The controller does not take this motion any more.
void Link::end_with(Cause cause, int detail) {
  stopped_ = true;
  stream_.out().clear();
  if (fault_) return;
  const Explained why = explain(cause, detail);
  note(cause, why.detail, why.text);
}

// --- judgement --------------------------------------------------------------------------------------------

void Link::judge(Nanoseconds now) {
  if (asked_ != Asked::nothing && owns_motion() && !lost_ && now - asked_at_ > settings_.timeout) {
    lost_ = true;
    note(Cause::moto_silent);
  }
  if (fault_) return;
  if (state_.is_open() && states_seen_ > 0 && now - heard_ > settings_.silence)
    return note(Cause::state_silent);
  if (phase_ != Phase::streaming) return;
  if (busy_since_ != 0 && now - busy_since_ > settings_.timeout) return note(Cause::points_stuck);
  if (begun_ && now - commanded_at_ > settings_.loop_silence) note(Cause::loop_silent);
}

/// Brakes behind the points that the controller has, and waits until its buffer is empty.
void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::streaming && fault_) phase_ = Phase::ending;
  if (phase_ != Phase::ending) {
    ending_since_ = now;
    return;
  }
  if (stands_) return;
  if (begun_ && !braked_ && !stopped_ && !lost_)
    for (int i = 0; i < kMostBrakeCycles && !stream_.stands(); ++i) stream_.brake(settings_.limits);
  braked_ = true;
  const bool out_of_reach = stopped_ || lost_;
  const bool empty = out_of_reach || (stream_.out().empty() && asked_ == Asked::nothing && queue_ == 0);
  const bool still = !state_.is_open() || now - heard_ > settings_.silence || stands_still();
  const Nanoseconds most = kEnd + static_cast<Nanoseconds>(settings_.lead_ms) * 1'000'000;
  if (begun_ && !(empty && still) && now - ending_since_ < most) return;
  stands_ = true;
  changed_.notify_all();
}

/// Every command is with the controller, or waits for its next state.
void Link::note_settled() {
  if (!settings_.stepped) return;
  const bool waits = stream_.out().empty() || retry_ || lost_ || stopped_ || !owns_motion();
  if (asked_ != Asked::nothing || !waits || (check_ && owns_motion() && !lost_ && !stopped_)) return;
  const std::lock_guard lock(mutex_);
  settled_commands_ = taken_;
  settled_states_ = current_.sequence;
  changed_.notify_all();
}

void Link::settle(Nanoseconds timeout) {
  // A sample of an earlier connection has another count.
  const std::uint64_t states = std::min(samples_.value().sequence, states_seen_.load());
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(timeout),
                    [&] { return fault_ || (settled_commands_ == pushed_ && settled_states_ >= states); });
}

}  // namespace polyarm::yaskawa
