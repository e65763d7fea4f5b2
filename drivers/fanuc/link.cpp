/// What a link does while it is open: the thread that reads, judges and answers.
#include "drivers/fanuc/link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

namespace {

constexpr Nanoseconds kLook = 20'000'000;       // between two judgements without an event
constexpr Nanoseconds kAsk = 100'000'000;       // between two questions for the alarm
constexpr Nanoseconds kSayWhy = 3'000'000'000;  // for the controller to say why it stopped
constexpr std::uint32_t kSayWhyMs = 700;        // the same on its clock; an emergency stop takes 500
constexpr Nanoseconds kEnd = 2'000'000'000;     // for the motion to end after the last command
constexpr std::uint32_t kMostGap = 1000;        // packets; a larger gap is a new start

}  // namespace

void Link::command(bool move, const Six& joints) noexcept {
  Wanted wanted{move, samples_.value().status.sequence, {}};
  for (std::size_t i = 0; i < 6; ++i) wanted.joints[i] = joints[i] / wire::kRadians;
  commands_.write(wanted);
  wake();
}

void Link::wait() {
  pollfd polled[3] = {{wake_.number(), POLLIN, 0},
                      {stream_.number(), POLLIN, 0},
                      {rmi_gone_ || !rmi_ ? -1 : rmi_.descriptor(), POLLIN, 0}};
  const timespec time{0, static_cast<long>(kLook)};
  ::ppoll(polled, 3, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait();
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    take_stream(now);
    if (!rmi_gone_ && rmi_) take_rmi();
    take_command(now);
    judge(now);
    answer_what_is_left();
    end(now);
  }
}

/// One packet at a time: commands are looked at between two of them.
void Link::take_stream(Nanoseconds now) {
  std::array<std::uint8_t, bounds::kStreamPacketBytes> bytes;
  const wire::Received got = wire::receive_datagram(stream_.number(), bytes);
  if (got.got != wire::Got::bytes) return;  // a port that nobody listens at is silent
  const auto status = decode_status(Bytes(bytes).first(got.count));
  if (!status) return note(Cause::bad_data);
  const std::uint64_t before = current_.count;
  // The loop's first command counts if it came before this packet. Looked at before the loop sees the packet,
  // so that a run repeats itself.
  if (phase_ != Phase::idle && !brakes() && !commanded_) commanded_ = commands_.fetch();
  take_status(*status, now);
  if (current_.count != before) answer(*status);
}

void Link::take_status(const Status& status, Nanoseconds now) {
  heard_ = now;
  const std::uint32_t steps = status.sequence - current_.status.sequence;
  const bool restarted = std::exchange(fresh_, false);
  if (!restarted && (steps == 0 || steps > kMostGap)) {  // twice, or behind a later one
    ++current_.repeated;
    samples_.write(current_);
    return;
  }
  if (!restarted) {
    current_.lost += steps - 1;
    const double dt = steps * sampling_ms_ / 1000.0;
    double way = 0;
    for (std::size_t i = 0; i < 3; ++i) way = std::hypot(way, status.pose[i] - current_.status.pose[i]);
    speed_ = way / dt;
    for (std::size_t i = 0; i < 6; ++i)
      current_.dq[i] =
          (static_cast<double>(status.joints[i]) - current_.status.joints[i]) * wire::kRadians / dt;
  } else {
    current_.dq = {};
    speed_ = 0;
  }
  current_.status = status;
  for (std::size_t i = 0; i < 6; ++i) current_.q[i] = static_cast<double>(status.joints[i]) * wire::kRadians;
  ++current_.count;
  samples_.write(current_);
  begin_cycle();
}

/// The loop's answer goes out when it comes; an answer that did not come is replaced by a step of a stop.
void Link::answer(const Status& status) {
  if (phase_ == Phase::idle) return send_idle(status);
  if (brakes()) return send_ending(status);
  if (!commanded_) return send_next(shaper_.at(), true, false, status.sequence);  // until the loop commands
  if (current_.answered + 1 != status.sequence)
    send_next(shaper_.brake(limits_.at(speed_, settings_.load)), true, false, status.sequence - 1);
  pacer_.cycle();
}

/// A command answers the packet that the loop had read. One that comes when that packet has its answer (at
/// the beginning, or too late) is not kept for the next one: the loop gives that one another command.
void Link::take_command(Nanoseconds now) {
  const bool fresh = commands_.fetch();  // first: its outputs were written before it
  if (outputs_.fetch()) {
    wanted_ = outputs_.value();
    fill_outputs();
  }
  if (fresh || !commanded_) pacer_.command(now);
  if (phase_ != Phase::streaming) return;
  if (fresh && !std::exchange(commanded_, true)) pacer_.sent();  // the position that is held
  if (!commanded_ || fault_ || suspected_ != 0) return;
  const bool open = current_.answered != current_.status.sequence;
  const bool ours = commands_.value().sequence == current_.status.sequence;
  if (settings_.follows ? !open || !ours : !pacer_.due()) return;
  const Wanted& wanted = commands_.value();
  const AxisLimits limits = limits_.at(speed_, settings_.load);
  const Six next = wanted.move ? shaper_.next(wanted.joints, limits) : shaper_.brake(limits);
  current_.behind = shaper_.behind() * wire::kRadians;
  current_.shaped = shaper_.shaped();
  send_next(next, true, false, current_.status.sequence);
  pacer_.sent();
  if (current_.behind > settings_.most_behind) {
    const std::size_t axis = shaper_.axis_behind();
    note(Cause::too_fast, static_cast<int>(3 * axis) + static_cast<int>(shaper_.exceeded(axis)));
  }
}

void Link::send_next(const Six& joints, bool motion, bool last, std::uint32_t sequence) {
  Command out;
  out.version = version_;
  out.sequence = sequence;
  out.motion = motion;
  out.last = last;
  out.io = io_area_;
  std::copy(joints.begin(), joints.end(), out.joints.begin());
  for (std::size_t i = 6; i < 9; ++i) out.joints[i] = current_.status.joints[i];
  wire::send_datagram(stream_.number(), encode(out));
  current_.answered = out.sequence;
}

/// Without motion: the controller's own values.
void Link::send_idle(const Status& status) {
  Six joints;
  for (std::size_t i = 0; i < 6; ++i) joints[i] = status.joints[i];
  send_next(joints, false, false, status.sequence);
}

/// Brakes, then says that it was the last command.
void Link::send_ending(const Status& status) {
  if (!motion_possible()) return send_idle(status);
  const bool still = shaper_.still();
  const Six next = shaper_.brake(limits_.at(speed_, settings_.load));
  last_sent_ = last_sent_ || (still && phase_ == Phase::ending);
  send_next(next, true, last_sent_, status.sequence);
}

/// A packet that waited for the loop when the motion began to end.
void Link::answer_what_is_left() {
  if (phase_ == Phase::idle || !brakes() || current_.answered == current_.status.sequence) return;
  send_ending(current_.status);
}

/// An output that nobody commands keeps its state.
void Link::fill_outputs() {
  const std::size_t states = io_[0].bytes();  // the outputs' states come behind those of the inputs
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double wanted = wanted_.digital[at];
    if (std::isfinite(wanted))
      set_digital(io_area_, 0, at, wanted > 0.5);
    else if (!commanded_)
      set_digital(io_area_, 0, at, digital(current_.status.io, states, at));
  }
}

void Link::take_rmi() {
  const Nanoseconds now = realtime::monotonic_now();
  const bool open = rmi_.poll([&](const RmiMessage& message) {
    if (message.name == "FRC_Terminate") note(Cause::terminated);
    if (message.name == "FRC_SystemFault" && phase_ == Phase::streaming) suspect(now);
    if (message.name != "FRC_ReadError" || suspected_ == 0) return;
    const std::string alarm = message.text("ErrorData");
    if (const Cause cause = cause_of_alarm(alarm); cause != Cause::none) note(cause, 0, alarm);
  });
  if (open) return;
  rmi_gone_ = true;
  note(Cause::rmi_closed);
}

/// Something ended the motion: the controller is asked why, and has a moment to answer.
void Link::suspect(Nanoseconds now) {
  if (suspected_ == 0) {
    suspected_ = now;
    suspected_ms_ = current_.status.time_ms;
    asked_ = 0;
  }
  if (now - asked_ < kAsk && asked_ != 0) return;
  asked_ = now;
  if (rmi_ && !rmi_gone_) rmi_.send(RmiLine("Command", "FRC_ReadError").number("Count", 1));
}

void Link::judge_status(Nanoseconds now) {
  const Status& status = current_.status;
  const bool contact = static_cast<ContactStop>(status.contact_stop) == ContactStop::stop;
  if (status.robot & emergency_bit) return note(Cause::emergency_stop);
  if (status.robot & teach_bit) return note(Cause::teach_mode);
  if (contact) return note(Cause::contact, status.contact_stop);
  if (status.robot & error_bit || !motion_possible()) suspect(now);
  if (suspected_ == 0) return;
  suspect(now);
  if (now - suspected_ < kSayWhy && status.time_ms - suspected_ms_ < kSayWhyMs) return;
  note(status.robot & error_bit ? Cause::alarm : Cause::program_stopped);
}

void Link::judge(Nanoseconds now) {
  if (now - heard_ > settings_.silence) note(Cause::stream_silent);
  if (phase_ != Phase::streaming || fault_) return;
  judge_status(now);
  if (!fault_ && suspected_ == 0 && commanded_ && pacer_.silent(now)) note(Cause::loop_silent);
}

void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::streaming && (stop_wanted_ || fault_)) {
    phase_ = Phase::ending;
    ending_since_ = now;
    suspected_ = 0;
  }
  if (phase_ != Phase::ending) return;
  const bool moving = (current_.status.status & moving_bit) != 0;
  const bool over = (last_sent_ && !moving) || !motion_possible();
  if (!over && now - ending_since_ < kEnd && now - heard_ < settings_.silence) return;
  phase_ = Phase::idle;
  changed_.notify_all();
}

}  // namespace polyarm::fanuc
