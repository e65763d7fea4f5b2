/// What a link does beside motion: the Ethernet server, signals, and why the robot stopped.
#include <algorithm>
#include <cmath>

#include "drivers/yaskawa/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr Nanoseconds kRound = 50'000'000;
constexpr std::uint32_t kOutputGroups = 1000;  // address of the first group of outputs, less 1

}  // namespace

/// The word of the answer; nothing if there was none, or MotoROS refused.
std::optional<std::uint32_t> Link::ask_io(MotoType what, std::uint32_t address, std::uint32_t value) {
  const bool writes = what == MotoType::write_bit;
  const ByteOrder order = io_.order();
  const auto body = writes ? words({address, value}, order) : words({address}, order);
  const auto answer = io_.ask(encode(Message{what, MotoComm::request, 0, body}, order), settings_.timeout);
  if (!answer) {
    if (!fault_) note(io_.failure().cause);
    return std::nullopt;
  }
  const auto got = read_words(*answer, writes ? 1 : 2, order);
  const auto ok = static_cast<std::uint32_t>(IoResult::ok);
  const bool answers = static_cast<int>(answer->type) == static_cast<int>(what) + 1;
  if (got && answers && (writes ? (*got)[0] : (*got)[1]) == ok) return (*got)[0];
  note(Cause::signal_refused, static_cast<int>(address));
  return std::nullopt;
}

/// Only what changed is written: somebody at the pendant may have switched the others.
bool Link::write_outputs() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!std::isfinite(wanted_.digital[at])) continue;
    const double wanted = wanted_.digital[at] > 0.5 ? 1 : 0;
    if (wanted == written_.digital[at]) continue;
    const std::uint32_t address = output_address(settings_.outputs.first + i);
    if (!ask_io(MotoType::write_bit, address, static_cast<std::uint32_t>(wanted))) return false;
    written_.digital[at] = wanted;
  }
  return true;
}

bool Link::read_signals(bool inputs, const wire::SignalRange& range, std::uint32_t& into) {
  if (range.count == 0) return true;
  const int first = (range.first - 1) / 8, last = (range.first + range.count - 2) / 8;
  for (int byte = first; byte <= last; ++byte) {
    const std::uint32_t group = static_cast<std::uint32_t>(byte + 1) + (inputs ? 0 : kOutputGroups);
    const auto value = ask_io(MotoType::read_group, group);
    if (!value) return false;
    into = (into & ~(0xFFu << 8 * byte)) | (*value & 0xFF) << 8 * byte;
  }
  return true;
}

bool Link::exchange_signals() {
  return write_outputs() && read_signals(true, settings_.inputs, current_panel_.inputs) &&
         read_signals(false, settings_.outputs, current_panel_.outputs);
}

bool Link::read_hses() {
  if (!settings_.hses) return true;
  const auto status = hses_.status();
  const auto pose = status ? hses_.pose() : std::nullopt;
  const auto torque = pose ? hses_.torque() : std::nullopt;
  if (!torque) {
    if (!fault_) note(hses_.failure().cause, hses_.failure().detail, hses_.failure().text);
    return false;
  }
  current_panel_.status = *status;
  current_panel_.pose = *pose;
  current_panel_.torque = *torque;
  current_panel_.seen = true;
  return true;
}

bool Link::serve_round() {
  const bool well = exchange_signals() && read_hses();
  if (well) panels_.write(current_panel_);
  return well;
}

void Link::serve_services() {
  const std::unique_lock lock(services_mutex_, std::try_to_lock);
  if (lock && open_ && !fault_) serve_round();
}

void Link::run_services() {
  Nanoseconds due = realtime::monotonic_now();
  while (!quit_) {
    const Nanoseconds left = due - realtime::monotonic_now();
    if (left > 0 && wire::wait_readable(services_wake_.number(), left)) calm(services_wake_.number());
    if (quit_ || realtime::monotonic_now() < due) continue;
    due = realtime::monotonic_now() + kRound;
    serve_services();  // does nothing after a fault
  }
}

/// The Ethernet server has the number and name of an alarm, and says what holds the robot.
Link::Explained Link::explain(Cause cause, int detail) {
  Explained out{cause == Cause::alarm ? alarm_code_.load() : detail, {}};
  const bool asks = cause == Cause::alarm || cause == Cause::error || cause == Cause::hold;
  if (!asks || !settings_.hses) return out;
  const std::lock_guard lock(services_mutex_);
  if (cause == Cause::hold) {
    const auto status = hses_.status();
    if (status)
      out.detail = status->pendant_hold ? 1 : status->external_hold ? 2 : status->command_hold ? 3 : 0;
    return out;
  }
  const auto alarm = hses_.alarm();
  if (!alarm || alarm->code == 0) return out;
  out.text = alarm->name;
  out.detail = static_cast<int>(alarm->code);
  return out;
}

}  // namespace polyarm::yaskawa
