/// What a link does while it is open: the thread that reads reports and sends servo commands.
#include "drivers/xarm/link.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kLook = 20'000'000;    // between two judgements without an event
constexpr Nanoseconds kEnd = 3'000'000'000;  // for a motion to end
constexpr double kStillWay = 1e-4;           // rad between two reports of a robot that stands
constexpr int kMostReads = 16;               // of the reports in one turn
constexpr int kDoubtfulReports = 3;          // until a command that was not taken ends the link
constexpr double kLate = 3.5;                // periods without a command until the robot is slowed down

std::vector<std::uint8_t> servo_data(const Seven& degrees) {
  UxData out;
  for (const double one : degrees) out.f32(one * wire::kRadians);
  return out.f32(0).f32(0).f32(0);  // speed, acceleration and time, which this mode does not use
}

}  // namespace

void Link::command(bool move, const Seven& joints) noexcept {
  Wanted wanted{move, {}};
  for (std::size_t i = 0; i < joints.size(); ++i) wanted.joints[i] = joints[i] / wire::kRadians;
  if (!commands_.push(wanted)) return fail(Cause::command_silent, 0);
  ++pushed_;
  wake();
}

void Link::wait() {
  pollfd polled[3] = {{wake_.number(), POLLIN, 0},
                      {report_socket_.number(), POLLIN, 0},
                      {owns_motion() && !lost_ ? motion_.descriptor() : -1, POLLIN, 0}};
  const bool by_time = begun_ && can_send() && !follows_reports();
  const timespec time{0, static_cast<long>(by_time ? nanoseconds(settings_.period / 2) : kLook)};
  ::ppoll(polled, 3, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait();
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (renew_) begin_streaming();
    take_reports(now);
    take_commands(now);
    bridge_gap(now);
    take_answers();
    send_next(now);
    judge(now);
    end(now);
    send_next(now);
    note_settled();
  }
}

/// What is left of an earlier session counts no more.
void Link::begin_streaming() {
  for (Wanted dropped; commands_.pop(dropped);) ++taken_;
  asked_ = pending_ = fresh_ = waited_ = begun_ = false;
  since_ = 0;
  brake_due_ = 0;
  braked_report_ = 0;
  commanded_at_ = realtime::monotonic_now();
  current_.behind = 0;
  current_.shaped = current_.replaced = 0;
  stands_ = lost_ = stopped_ = false;
  doubt_ = Cause::none;
  const std::lock_guard lock(mutex_);
  renewed();
}

// --- reports ----------------------------------------------------------------------------------------------

/// False: the connection is of no use.
bool Link::receive_reports() {
  std::array<std::uint8_t, 4096> buffer;
  for (int turn = 0; turn < kMostReads; ++turn) {
    const wire::Received got = wire::receive(report_socket_.number(), buffer);
    if (got.got == wire::Got::nothing) return true;
    if (got.got != wire::Got::bytes) {
      note(Cause::closed);
      return false;
    }
    if (!report_reader_.feed(Bytes(buffer).first(got.count))) {
      note(Cause::bad_data);
      return false;
    }
    if (got.count < buffer.size()) return true;
  }
  return true;
}

void Link::take_reports(Nanoseconds now) {
  if (!report_socket_) return;
  const bool well = receive_reports();
  while (const auto bytes = report_reader_.next()) {
    const auto report = decode_report(*bytes, ReportKind::real);
    if (report) {
      take_report(*report, now);
      continue;
    }
    note(Cause::bad_data);
    break;
  }
  if (!well) report_socket_ = Descriptor();
}

void Link::take_report(const Report& report, Nanoseconds now) {
  const double dt = settings_.report_period > 0 ? settings_.report_period : seconds(now - heard_);
  double way = 0;
  for (std::size_t i = 0; i < kWireJoints; ++i) {
    const double q = report.position[i];
    way = std::max(way, std::abs(q - current_.q[i]));
    current_.dq[i] = dt > 1e-4 && current_.sequence > 0 ? (q - current_.q[i]) / dt : 0;
    current_.q[i] = q;
  }
  still_reports_ = way < kStillWay ? still_reports_ + 1 : 0;
  current_.report = report;
  heard_ = now;
  ++current_.sequence;
  mode_ = static_cast<int>(report.mode);
  state_ = static_cast<int>(report.state);
  samples_.write(current_);
  if (phase_ == Phase::streaming && !fault_) {
    judge_report(report);
    judge_doubt();
  }
  begin_cycle();
  const std::lock_guard lock(mutex_);
  reports_seen_ = current_.sequence;
  changed_.notify_all();
}

void Link::judge_report(const Report& report) {
  if (report.state == State::paused) return end_with(Cause::paused, 0);
  if (!ready_state(static_cast<int>(report.state))) {
    const PanelPort::Why why = explain_stop();
    if (why.cause != Cause::stopped || report.mode == Mode::servo) return end_with(why.cause, why.detail);
  }
  if (report.mode != Mode::servo) end_with(Cause::mode_changed, static_cast<int>(report.mode));
}

// --- commands ---------------------------------------------------------------------------------------------

void Link::take_commands(Nanoseconds now) {
  for (Wanted wanted; commands_.pop(wanted);) {
    ++taken_;
    if (phase_ != Phase::streaming || fault_) continue;
    commanded_at_ = now;
    if (!begun_) {
      Seven at;
      for (std::size_t i = 0; i < at.size(); ++i) at[i] = current_.q[i] / wire::kRadians;
      shaper_.begin(at);
      begun_ = true;
    }
    if (++since_ < settings_.cycles) continue;
    since_ = 0;
    feed(wanted);
  }
}

void Link::feed(const Wanted& wanted) {
  if (pending_) {
    ++current_.replaced;
    waited_ = waited_ || asked_;
  }
  pending_ = fresh_ = true;
  newest_ = wanted;
  braked_report_ = current_.sequence;  // braking goes on from here a period later
  brake_due_ = commanded_at_ + nanoseconds(settings_.period);
  if (!wanted.move || !answer_is_late(commanded_at_)) return;
  const Seven& sent = shaper_.at();
  for (std::size_t i = 0; i < sent.size(); ++i)
    if (std::abs(wanted.joints[i] - sent[i]) * wire::kRadians > settings_.most_behind)
      return note(Cause::command_silent);
}

bool Link::answer_is_late(Nanoseconds now) const noexcept {
  return asked_ && !settings_.stepped && now - asked_at_ > nanoseconds(kLate * settings_.period);
}

/// One step towards the newest command of the loop. A step belongs to a command that is sent: after a late
/// answer, or several commands of the loop at once, the next target is no farther away than any other one.
void Link::shape() {
  fresh_ = false;
  if (newest_.move && !fault_)
    shaper_.next(newest_.joints, settings_.limits);
  else
    shaper_.brake(settings_.limits);
  if (shaper_.behind() == 0) waited_ = false;
  current_.behind = shaper_.behind() * wire::kRadians;
  current_.shaped = shaper_.shaped();
  judge_behind(shaper_, current_.behind, settings_.most_behind,
               waited_ ? Cause::command_silent : Cause::none);
}

/// One command at a time, always the newest one.
void Link::send_next(Nanoseconds now) {
  if (!can_send() || asked_ || !pending_) return;
  pending_ = false;
  if (fresh_) shape();
  if (!motion_.send(Register::servo_joint, servo_data(shaper_.at()))) {
    lost_ = true;
    return note(motion_.failure().cause);
  }
  asked_ = true;
  asked_at_ = now;
}

void Link::take_answers() {
  if (!owns_motion() || lost_) return;
  const bool well = motion_.receive();
  const auto reply = motion_.next();
  if (!well || !motion_.is_open()) {
    lost_ = true;
    return note(motion_.failure().cause);
  }
  if (!reply) return;
  if (phase_ == Phase::ending && answer_is_late(realtime::monotonic_now())) {
    pending_ = fresh_ = false;
    shaper_.begin(shaper_.at());  // meanwhile the robot has come to rest there
  }
  asked_ = false;
  if (reply->bits & kErrorBit) {
    const PanelPort::Why why = explain_stop();
    return end_with(why.cause, why.detail);
  }
  if (!(reply->bits & (kNotReadyBit | kInvalidBit))) return;
  stopped_ = true;  // the next reports say why
  pending_ = false;
  doubt_ = reply->bits & kInvalidBit ? Cause::command_refused : Cause::not_ready;
  doubtful_reports_ = 0;
}

/// The controller did not take a command, and its reports show no reason.
void Link::judge_doubt() {
  if (fault_ || doubt_ == Cause::none || ++doubtful_reports_ < kDoubtfulReports) return;
  const PanelPort::Why why = doubt_ == Cause::not_ready ? explain_stop() : PanelPort::Why{doubt_, 0, {}};
  end_with(why.cause, why.detail);
}

/// The controller does not take this motion any more.
void Link::end_with(Cause cause, int detail) {
  stopped_ = true;
  pending_ = false;
  if (!fault_) note(cause, detail);
}

// --- judgement --------------------------------------------------------------------------------------------

void Link::judge(Nanoseconds now) {
  if (asked_ && owns_motion() && !lost_ && now - asked_at_ > settings_.timeout) {
    lost_ = true;
    note(Cause::command_silent);
  }
  if (fault_) return;
  if (reports_seen_ > 0 && now - heard_ > settings_.silence) return note(Cause::report_silent);
  if (phase_ != Phase::streaming) return;
  if (begun_ && now - commanded_at_ > settings_.loop_silence) note(Cause::loop_silent);
}

/// A cycle of the fastest stop: with each period, or with each report of a controller whose clock waits.
void Link::brake_on(Nanoseconds now) {
  if (asked_ || pending_ || shaper_.still()) return;
  if (follows_reports() ? braked_report_ == current_.sequence : now < brake_due_) return;
  braked_report_ = current_.sequence;
  brake_due_ = now + nanoseconds(settings_.period);
  shaper_.brake(settings_.limits);
  pending_ = true;
  fresh_ = false;
}

/// Without commands the controller would hold its last target, from full speed. The robot is slowed down
/// instead; a command that comes later goes on from there.
void Link::bridge_gap(Nanoseconds now) {
  if (settings_.stepped || phase_ != Phase::streaming || !begun_ || fault_ || !can_send()) return;
  if (now - commanded_at_ > nanoseconds(kLate * settings_.period)) brake_on(now);
}

/// Brakes, and waits until the robot stands.
void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::streaming && fault_) phase_ = Phase::ending;
  if (phase_ != Phase::ending) {
    ending_since_ = now;
    return;
  }
  if (stands_) return;
  if (begun_ && can_send()) brake_on(now);
  const bool out_of_reach = stopped_ || lost_;
  const bool braked = out_of_reach || (shaper_.still() && !asked_ && !pending_);
  const bool still = !report_socket_ || now - heard_ > settings_.silence || stands_still();
  if (begun_ && !(braked && still) && now - ending_since_ < kEnd) return;
  stands_ = true;
  changed_.notify_all();
}

/// Every command is with the controller.
void Link::note_settled() {
  if (!settings_.stepped) return;
  if ((asked_ || pending_) && can_send()) return;
  const std::lock_guard lock(mutex_);
  settled_commands_ = taken_;
  settled_reports_ = current_.sequence;
  changed_.notify_all();
}

void Link::settle(Nanoseconds timeout) {
  // A sample of an earlier connection has another count.
  const std::uint64_t reports = std::min(samples_.value().sequence, reports_seen_.load());
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(timeout),
                    [&] { return fault_ || (settled_commands_ == pushed_ && settled_reports_ >= reports); });
}

}  // namespace polyarm::xarm
