/// What a link does while it is open: the thread that reads, judges and sends.
#include "drivers/ur/link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::ur {

namespace {
constexpr Nanoseconds kGrace = 200'000'000;  // for other wires to say why the program closed its connection
constexpr Nanoseconds kLook = 20'000'000;    // between two judgements without an event
constexpr double kTimeout = 25;   // cycles beyond the watchdog's, for the program to take a command
constexpr double kMostGap = 100;  // cycles; a larger gap in the controller's time is a restart
}  // namespace

std::int32_t Link::command(Mode mode, const std::array<double, 6>& values) noexcept {
  sequence_ = sequence_ == std::numeric_limits<std::int32_t>::max() ? 1 : sequence_ + 1;
  commands_.write(Command{sequence_, mode, values});
  wake();
  return sequence_;
}

void Link::outputs(const Outputs& outputs) noexcept {
  outputs_.write(outputs);
  wake();
}

std::optional<Kinematics> Link::kinematics() const {
  const std::lock_guard lock(mutex_);
  if (!nominal_ || !calibrated_) return std::nullopt;
  return calibrated_->stated() ? *calibrated_ : *nominal_;
}

void Link::wait() {
  pollfd polled[5] = {{wake_.number(), POLLIN, 0}, {rtde_.number(), POLLIN, 0}};
  nfds_t count = 2;
  for (const Descriptor* one : {&primary_, &listener_, &stream_})
    if (*one && !(one == &primary_ && primary_lost_)) polled[count++] = {one->number(), POLLIN, 0};
  const timespec time{0, static_cast<long>(kLook)};
  if (!rtde_) polled[1].fd = -1;
  ::ppoll(polled, count, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait();
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (rtde_) take_rtde(now);
    if (!primary_lost_) take_primary();
    accept_stream();
    if (stream_) take_stream();
    take_commands(now);
    judge(now);
    finish_stopping(now);
  }
}

void Link::take_rtde(Nanoseconds now) {
  std::array<std::uint8_t, 8192> bytes;
  for (;;) {
    const wire::Received got = wire::receive(rtde_.number(), bytes);
    if (got.got == wire::Got::nothing) return;
    if (got.got != wire::Got::bytes) {
      rtde_ = Descriptor();
      return note(Cause::rtde_closed);
    }
    const bool whole = frames_.feed(Bytes(bytes).first(got.count), [&](PackageType type, Bytes payload) {
      if (type == PackageType::data) take_package(payload, now);
    });
    if (whole) continue;
    rtde_ = Descriptor();
    return note(Cause::bad_data, 0, "a package of no size");
  }
}

void Link::take_package(Bytes payload, Nanoseconds now) {
  if (protocol_ >= 2) {
    if (payload.empty() || payload.front() != recipe_.id)
      return note(Cause::bad_data, 0, "a package of another recipe");
    payload = payload.subspan(1);
  }
  if (!decode(recipe_, payload, std::span(decoded_).first(recipe_.elements)))
    return note(Cause::bad_data, 0, "a package of another size");
  heard_ = now;
  const double elapsed = decoded_[0] - current_[kTimestamp], period = 1 / rate_;
  if (current_.count > 0 && elapsed < 0.5 * period) {  // twice, or behind a later one
    ++current_.repeated;
    samples_.write(current_);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    if (current_.count > 0 && elapsed > 1.5 * period && elapsed < kMostGap)
      current_.lost += static_cast<std::uint64_t>(std::lround(elapsed / period)) - 1;
    const double state = current_[kRuntimeState];
    std::size_t at = 0;
    for (const Field field : fields_)
      for (std::size_t i = place_of(field); i < place_of(static_cast<Field>(field + 1)); ++i)
        current_.values[i] = decoded_[at++];
    ++current_.count;
    current_.streaming = streams();
    const bool untaken = commanded_ && current_[kSequence] != sent_sequence_;
    unread_ = untaken && current_[kSequence] == taken_sequence_ ? unread_ + 1 : 0;
    taken_sequence_ = current_[kSequence];
    if (current_.count == 1 || current_[kRuntimeState] != state) changed_.notify_all();
  }
  take_moves();
  samples_.write(current_);
  pacer_.cycle();
  begin_cycle();
}

MoveReport Link::move_report() const {
  const auto whole = [this](Field field) {
    const double value = current_[field];
    return std::abs(value) < 0x1p31 ? static_cast<int>(value) : 0;  // a conversion outside of it is undefined
  };
  MoveReport out{current_[kTimestamp], {}, whole(kMoveEnded), whole(kMoveHalted)};
  std::copy_n(current_.values.begin() + place_of(kPosition), 6, out.q.begin());
  return out;
}

/// Before the loop hears of the cycle: what it then reads of the moves belongs to this one.
void Link::take_moves() {
  if (!moves_ || !stream_) return;
  moves_->take(move_report());
  if (const auto joint = moves_->off_target()) note(Cause::off_target, *joint);
  if (moves_->awaits_halt_too_long()) note(Cause::not_reading);
}

void Link::take_primary() {
  std::array<std::uint8_t, 8192> bytes;
  std::vector<PrimaryEvent> events;
  for (;;) {
    const wire::Received got = wire::receive(primary_.number(), bytes);
    if (got.got == wire::Got::nothing) break;
    const bool whole = got.got == wire::Got::bytes && messages_.feed(Bytes(bytes).first(got.count), events);
    if (!whole) {  // the robot moves without it; only the words are missing
      primary_lost_ = true;
      break;
    }
  }
  const std::lock_guard lock(mutex_);
  for (const PrimaryEvent& event : events) {
    using Kind = PrimaryEvent::Kind;
    if (event.kind == Kind::configuration) nominal_ = event.kinematics;
    if (event.kind == Kind::kinematics) calibrated_ = event.kinematics;
    if (event.kind == Kind::exception && phase_ != Phase::idle)
      exception_ = event.text + " in line " + std::to_string(event.code);
    if (event.kind == Kind::error && event.code == kReadOnly && phase_ == Phase::starting)
      refusal_ = event.text.empty() ? "the port is read-only" : event.text;
  }
  if (!events.empty()) changed_.notify_all();
}

void Link::accept_stream() {
  Descriptor socket = wire::accept_tcp(listener_.number());
  if (!socket) return;
  const std::lock_guard lock(mutex_);
  const bool ours = wire::peer_address(socket.number()) == controller_;
  if (phase_ != Phase::starting || !ours) return;  // nobody is expected, or a stranger: closed at once
  stream_ = std::move(socket);
  phase_ = Phase::streaming;
  played_ = commanded_ = ending_ = false;
  closed_ = 0;
  unread_ = 0;
  commands_.fetch();  // what was commanded before counts no more
  if (moves_) {
    moves_->begin(move_report());
    if (!slider_before_) slider_before_ = current_[kSpeedSlider];
    written_.speed_slider = std::numeric_limits<double>::quiet_NaN();
  }
  pacer_ = wire::Pacer(Nanoseconds{settings_.watchdog_ms} * 1'000'000);
  pacer_.begin(realtime::monotonic_now());
  changed_.notify_all();
}

void Link::take_stream() {
  std::array<std::uint8_t, 256> bytes;
  for (;;) {
    const wire::Received got = wire::receive(stream_.number(), bytes);
    if (got.got == wire::Got::bytes) continue;
    if (got.got == wire::Got::nothing) return;
    stream_ = Descriptor();
    closed_ = realtime::monotonic_now();
    return;
  }
}

void Link::send_command(const Command& command) {
  if (moves_) {
    MoveMessage message = commanded_ ? message_of(moves_->next(), moves_->frame()) : MoveMessage{};
    hold_slider();
    message.sequence = command.sequence;
    message.timeout_ms = settings_.watchdog_ms;
    send(command.sequence, encode(message));
  } else {
    send(command.sequence,
         encode(Message{command.sequence, settings_.watchdog_ms, command.mode, command.values}));
  }
}

void Link::send_end() {
  if (moves_)
    send(0, encode(MoveMessage{0, settings_.watchdog_ms, Work::end}));
  else
    send(0, encode(Message{0, settings_.watchdog_ms, Mode::end, {}}));
}

void Link::send(std::int32_t sequence, std::span<const std::uint8_t> bytes) {
  if (!stream_) return;
  sent_sequence_ = sequence;
  if (wire::send_frame(stream_.number(), bytes)) return;
  pollfd one{stream_.number(), 0, 0};
  ::poll(&one, 1, 0);
  if (one.revents & (POLLHUP | POLLERR)) return;  // closed: judge() finds the cause
  note(Cause::not_reading);
}

/// The slider goes out before the message: a move begins at its pace. Somebody at the pendant may move it
/// while the robot slows down to rest; then it is sent again.
void Link::hold_slider() {
  constexpr std::uint64_t kAgain = 25;  // cycles
  if (moves_->slider() == 0 && current_[kSpeedSlider] > 1e-3 && current_.count % kAgain == 0)
    written_.speed_slider = std::numeric_limits<double>::quiet_NaN();
  send_outputs();
}

void Link::send_outputs() {
  Outputs wanted = outputs_.value();
  if (moves_) wanted.speed_slider = moves_->slider().value_or(std::numeric_limits<double>::quiet_NaN());
  const auto only_changed = [](double& now, double& before) {
    const double last = std::exchange(before, now);
    if (now == last) now = std::numeric_limits<double>::quiet_NaN();
    return std::isfinite(now);
  };
  bool any = only_changed(wanted.speed_slider, written_.speed_slider);
  for (std::size_t i = 0; i < Outputs::kDigital; ++i)
    any = only_changed(wanted.digital[i], written_.digital[i]) || any;
  for (std::size_t i = 0; i < Outputs::kAnalog; ++i)
    any = only_changed(wanted.analog[i], written_.analog[i]) || any;
  if (!any || !rtde_ || inputs_.types.empty()) return;
  std::array<double, 12> values{};
  const auto whole = [](double value) {
    return static_cast<double>(std::lround(std::clamp(value, 0.0, 1.0)));
  };
  constexpr std::size_t kGroup[] = {2, 4, 6};  // places of the masks
  for (std::size_t bit = 0; bit < Outputs::kDigital; ++bit) {
    if (!std::isfinite(wanted.digital[bit])) continue;
    const std::size_t mask = kGroup[bit / 8];
    const double weight = 1 << bit % 8;
    values[mask] += weight;
    values[mask + 1] += weight * whole(wanted.digital[bit]);
  }
  if (std::isfinite(wanted.speed_slider)) {
    values[0] = 1;
    values[1] = std::clamp(wanted.speed_slider, 0.0, 1.0);
  }
  for (std::size_t i = 0; i < Outputs::kAnalog; ++i)
    if (std::isfinite(wanted.analog[i])) {
      values[8] += 1 << i;
      values[9] += 1 << i;  // volts
      values[10 + i] = std::clamp(wanted.analog[i], 0.0, 1.0);
    }
  wire::Writer out;
  if (protocol_ >= 2) out.u8(inputs_.id);
  encode(inputs_, values, out);
  wire::send_frame(rtde_.number(), frame(PackageType::data, out));
}

void Link::take_commands(Nanoseconds now) {
  const bool fresh = commands_.fetch();  // first: its outputs were written before it
  if (outputs_.fetch()) send_outputs();
  if (!stream_ || ending_) return;
  if (fresh) {
    if (!commanded_) pacer_.cycle();  // the first one replaces what kept the program waiting
    commanded_ = true;
    pacer_.command(now);
  } else if (!commanded_) {
    pacer_.command(now);  // until the loop commands, the robot's program is kept waiting
  }
  if (fault_ || !pacer_.due()) return;
  send_command(commanded_ ? commands_.value() : Command{});
  pacer_.sent();
}

void Link::judge(Nanoseconds now) {
  if (now - heard_ > settings_.silence) note(Cause::rtde_silent);
  std::unique_lock lock(mutex_);
  const bool streaming = phase_ == Phase::streaming && !stop_wanted_;
  const std::string exception = exception_;
  lock.unlock();
  if (streaming && !fault_) {
    if (!exception.empty()) note(Cause::script_error, 0, exception);
    judge_program(now);
  }
  if (fault_ && (phase_ == Phase::streaming)) end_stream();
}

void Link::judge_program(Nanoseconds now) {
  const auto value = [this](Field field) { return static_cast<int>(current_[field]); };
  const Obstacle obstacle = obstacle_of(value(kRobotMode), value(kSafetyMode));
  if (obstacle.cause != Cause::none) return note(obstacle.cause, obstacle.detail);
  const int state = value(kRuntimeState), script = value(kScriptState);
  played_ = played_ || state == playing;
  if (played_ && (state == paused || state == pausing)) return note(Cause::program_paused);
  if (played_ && script == static_cast<int>(ScriptState::timed_out)) return note(Cause::commands_late);
  if (played_ && script == static_cast<int>(ScriptState::jumped)) return note(Cause::jump, -1);
  if (played_ && (state == stopped || state == stopping)) return note(Cause::program_stopped);
  if (unread_ > rate_ * settings_.watchdog_ms / 1000 + kTimeout) return note(Cause::not_reading);
  if (closed_ != 0 && now - closed_ > kGrace) return note(Cause::reverse_closed);
  if (commanded_ && stream_ && pacer_.silent(now)) return note(Cause::loop_silent);
}

/// A program that does not read its messages would go on with the moves that it has, and so would one that is
/// paused, by a person or by a stop that is lifted later. One that came to its end leaves the slider to other
/// programs.
void Link::end_at_the_controller() {
  constexpr Cause kGoesOn[] = {Cause::program_paused, Cause::not_reading, Cause::protective_stop,
                               Cause::safeguard_stop};
  if (std::ranges::find(kGoesOn, fault_.cause()) != std::end(kGoesOn))
    wire::send_frame(primary_.number(), "stop program\n");
  if (!moves_ || fault_ || stream_ || inputs_.types.empty() || !rtde_ || !slider_before_) return;
  moves_->leave_slider(*slider_before_);
  slider_before_.reset();
  send_outputs();
}

/// The robot's program stops the robot at the command `end`, and when its connection closes.
void Link::end_stream() {
  send_end();
  end_at_the_controller();
  stream_ = Descriptor();
  const std::lock_guard lock(mutex_);
  phase_ = Phase::idle;
  changed_.notify_all();
}

/// stop(): first the word, then the connection's end, which the program makes when the robot stands.
void Link::finish_stopping(Nanoseconds now) {
  std::unique_lock lock(mutex_);
  if (!stop_wanted_ || phase_ == Phase::idle) return;
  const bool starting = phase_ == Phase::starting;
  lock.unlock();
  if (!ending_ && stream_) {
    send_end();
    ending_ = true;
    ended_ = now;
  }
  if (starting || !stream_ || now - ended_ > settings_.connect_timeout / 2) end_stream();
}

}  // namespace polyarm::ur
