/// How a link begins and ends: versions, limits, inputs and outputs, the program that streams.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/fanuc/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

namespace {

constexpr Nanoseconds kAgain = 300'000'000;  // between two requests that got no answer
constexpr Nanoseconds kPause = 50'000'000;
constexpr int kFresh = 3;  // packets
constexpr int kCalls = 3;  // of the streaming program: ending the previous one can drop the first call

IoRow row_of(IoDirection direction, IoKind kind, const IoRange& range) {
  return {direction, static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(range.first),
          static_cast<std::uint32_t>(range.count)};
}

}  // namespace

Outputs::Outputs() noexcept {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

Link::Link(LinkSettings settings)
    : RmiLink("the controller at " + settings.host, settings.connect_timeout),
      settings_(std::move(settings)),
      pacer_(0) {}

/// Sends a request of Stream Motion until its answer comes. Other packets in between are dropped.
template <typename Decode>
auto Link::ask_stream(const std::vector<std::uint8_t>& request, Decode decode) -> decltype(decode(Bytes{})) {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.connect_timeout;
  std::array<std::uint8_t, bounds::kStreamPacketBytes> bytes;
  for (Nanoseconds now = 0; (now = realtime::monotonic_now()) < deadline;) {
    wire::send_datagram(stream_.number(), request);
    const Nanoseconds again = std::min(deadline, now + kAgain);
    while ((now = realtime::monotonic_now()) < again) {
      if (!wire::wait_readable(stream_.number(), again - now)) break;
      const wire::Received got = wire::receive_datagram(stream_.number(), bytes);
      if (got.got == wire::Got::failed) wire::wait_readable(wake_.number(), kPause);
      if (got.got != wire::Got::bytes) continue;
      if (auto answer = decode(Bytes(bytes).first(got.count))) return answer;
    }
  }
  return {};
}

void Link::send_stop() {
  if (stream_) wire::send_datagram(stream_.number(), encode_stop(version_));
}

bool Link::connect_stream() {
  std::string why;
  stream_ = wire::connect_udp(settings_.host, settings_.stream_port, why);
  if (!stream_) return refuse(Cause::unreachable, 0, why);
  version_ = kOldestVersion;
  send_stop();  // without it a controller refuses the next start after a broken connection
  const auto answer = ask_stream(encode(Capability{}), decode_capability);
  if (!answer) return refuse(Cause::stream_silent);
  if (answer->available < kOldestVersion || answer->available > kNewestVersion)
    return refuse(Cause::wrong_version, static_cast<int>(std::min(answer->available, 9999u)));
  if (answer->sampling_ms < 1 || answer->sampling_ms > 100)
    return refuse(Cause::bad_data, 0, "a sampling time of " + std::to_string(answer->sampling_ms) + " ms");
  version_ = answer->available;
  sampling_ms_ = answer->sampling_ms;
  shaper_ = Shaper(sampling_ms_ / 1000.0);
  return true;
}

bool Link::read_limits() {
  limits_ = {};
  for (std::uint32_t axis = 1; axis <= 6; ++axis)
    for (const LimitKind kind : {LimitKind::velocity, LimitKind::acceleration, LimitKind::jerk}) {
      const auto fits = [&](Bytes packet) {
        auto table = decode_limits(packet);
        if (table && (table->axis != axis || table->kind != kind)) table.reset();
        return table;
      };
      const auto table = ask_stream(encode(LimitRequest{version_, axis, kind}), fits);
      if (!table) return refuse(Cause::no_limits, static_cast<int>(axis));
      limits_.set(*table);
    }
  return true;
}

bool Link::set_up_io(bool with_outputs) {
  io_ = {};
  if (settings_.inputs.count > 0) io_[0] = row_of(IoDirection::state, IoKind::digital_in, settings_.inputs);
  if (settings_.outputs.count > 0)
    io_[1] = row_of(IoDirection::state, IoKind::digital_out, settings_.outputs);
  if (settings_.outputs.count > 0 && with_outputs)
    io_[2] = row_of(IoDirection::command, IoKind::digital_out, settings_.outputs);
  const auto result = ask_stream(encode(io_, version_), decode_io_result);
  if (!result) return refuse(Cause::stream_silent);
  return *result == 0 ? true : refuse(Cause::io_refused, static_cast<int>(std::min(*result, 99'999'999u)));
}

/// Packets come from then on; each one gets an answer, the first one too.
bool Link::begin_stream(bool with_outputs) {
  send_stop();
  if (!set_up_io(with_outputs)) return false;
  fresh_ = true;
  commanded_ = false;
  const auto first = ask_stream(encode_start(version_), decode_status);
  if (!first) return refuse(Cause::stream_silent);
  take_status(*first, realtime::monotonic_now());
  outputs_.fetch();  // what was wanted before counts no more
  wanted_ = Outputs();
  fill_outputs();
  send_idle(*first);
  return true;
}

bool Link::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  const bool fine = connect_stream() && read_limits() &&
                    connect_rmi(settings_.host, settings_.rmi_port, true) && begin_stream(false);
  if (!fine) {
    close();
    return false;
  }
  run_thread();
  return true;
}

void Link::close() {
  stop();
  halt_thread();
  abort_program();
  rmi_.close(settings_.connect_timeout);
  send_stop();
  stream_ = Descriptor();
}

void Link::run_thread() {
  quit_ = rmi_gone_ = false;
  heard_ = realtime::monotonic_now();
  thread_ = std::thread([this] { run(); });
}

void Link::halt_thread() {
  if (!thread_.joinable()) return;
  quit_ = true;
  wake();
  thread_.join();
}

/// What a person has to change at the robot first.
bool Link::check_state() {
  const Status& status = current_.status;
  if (status.robot & emergency_bit) return refuse(Cause::emergency_stop);
  if (status.robot & teach_bit) return refuse(Cause::teach_mode);
  if (static_cast<ContactStop>(status.contact_stop) == ContactStop::stop)
    return refuse(Cause::contact, status.contact_stop);
  const auto answer = command_of("FRC_GetStatus");
  if (!answer) return false;
  return answer->number("TPMode") != 0 ? refuse(Cause::teach_mode) : true;
}

bool Link::call_program() {
  const auto status = command_of("FRC_GetStatus");
  if (!status) return false;
  RmiLine call("Instruction", "FRC_Call");
  call.number("SequenceID", status->whole("NextSequenceID", 0, 1 << 30).value_or(1));
  call.text("ProgramName", "STREAM_MOTN");
  called_ = true;
  return rmi_.send(call) ? true : refuse(Cause::rmi_silent, 0, "FRC_Call");
}

void Link::abort_program() {
  if (std::exchange(called_, false) && rmi_)
    rmi_.ask("Command", "FRC_Abort", {"Command", "FRC_Abort"}, settings_.connect_timeout);
}

/// Takes one packet and answers it without motion. False: none came.
bool Link::answer_one(Nanoseconds timeout) {
  std::array<std::uint8_t, bounds::kStreamPacketBytes> bytes;
  if (!wire::wait_readable(stream_.number(), timeout)) return false;
  const wire::Received got = wire::receive_datagram(stream_.number(), bytes);
  if (got.got != wire::Got::bytes) return false;
  if (const auto status = decode_status(Bytes(bytes).first(got.count))) {
    take_status(*status, realtime::monotonic_now());
    send_idle(*status);
  }
  return true;
}

bool Link::await_ready() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.start_timeout;
  int error = 0;
  while (realtime::monotonic_now() < deadline) {
    const bool open = rmi_.poll([&](const RmiMessage& message) {
      if (message.kind == RmiMessage::Kind::instruction && message.error() != 0) error = message.error();
    });
    if (!open) return refuse(Cause::rmi_closed);
    if (error != 0) return refuse(Cause::rmi_refused, error, "its program STREAM_MOTN");
    if (!answer_one(kPause) && realtime::monotonic_now() - heard_ > settings_.start_timeout / 2)
      return refuse(Cause::stream_silent);
    if (motion_possible()) return true;
  }
  return refuse_alarm(Cause::not_ready);
}

bool Link::hold_ready() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.settle;
  while (realtime::monotonic_now() < deadline) {
    answer_one(kPause);
    if (!motion_possible()) return false;
  }
  return true;
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::stream_silent);
  if (fault_) return false;
  refused_.clear();
  halt_thread();
  for (int i = 0; i < kFresh; ++i) answer_one(kPause);  // what a person has just changed counts
  bool fine = check_state() && clear_alarms(settings_.start_timeout) && initialize();
  for (int call = 0; fine; ++call) {
    fine = call_program() && begin_stream(true) && await_ready();
    if (fine && hold_ready()) break;
    if (fine && call + 1 == kCalls) fine = refuse_alarm(Cause::not_ready);
  }
  if (fine && (current_.status.robot & (error_bit | emergency_bit | teach_bit)))
    fine = refuse_alarm(Cause::alarm);
  if (fine) {
    const std::lock_guard lock(mutex_);
    Six measured;
    std::copy_n(current_.status.joints.begin(), 6, measured.begin());
    shaper_.begin(measured);
    commands_.fetch();  // what was commanded before counts no more
    pacer_ = wire::Pacer(settings_.loop_silence);
    pacer_.begin(realtime::monotonic_now());
    commanded_ = last_sent_ = stop_wanted_ = false;
    suspected_ = 0;
    phase_ = Phase::streaming;
  } else if (rmi_) {
    abort_program();
    const auto why = refused_.value();
    const std::string said = text();
    begin_stream(false);
    refuse(why.cause, why.detail, said);
  }
  run_thread();
  return fine;
}

void Link::stop() {
  std::unique_lock lock(mutex_);
  if (phase_ == Phase::idle) return;
  stop_wanted_ = true;
  lock.unlock();
  wake();
  lock.lock();
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.connect_timeout),
                    [this] { return phase_ == Phase::idle; });
  lock.unlock();
  halt_thread();
  phase_ = Phase::idle;
  abort_program();
  if (fault_) return;
  if (!begin_stream(false)) fault_.set(refused_.value());
  run_thread();
}

}  // namespace polyarm::fanuc
