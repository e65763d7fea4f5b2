/// What a link does beside motion: errors and signals, over a connection of its own.
#include <cmath>

#include "drivers/xarm/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kRound = 50'000'000;
constexpr int kTool = 9;  // the board at the tool
constexpr std::uint16_t kToolInputs = 0x0A14, kToolOutputs = 0x0A15;
constexpr std::size_t kIoInputs = 4, kIoOutputs = 8;  // places in the state of the signals
constexpr int kHalf = 8;                              // signals in one word

}  // namespace

/// False: the connection is of no use, and the cause is noted.
bool Link::ask_service(Register reg, const std::vector<std::uint8_t>& data, std::optional<UxReply>& reply) {
  reply = services_port_.ask(reg, data, settings_.timeout);
  if (!reply && !fault_) note(services_port_.failure().cause, 0, services_port_.failure().text);
  return reply.has_value();
}

/// A word has eight signals: which ones are written, and their values.
bool Link::write_output(std::size_t at, bool on) {
  std::optional<UxReply> reply;
  if (at >= kMostSignals) {
    const std::size_t bit = at - kMostSignals;
    const double word = static_cast<double>(0x0100u << bit | (on ? 1u : 0u) << bit);
    if (!ask_service(Register::tool_write, UxData().u8(kTool).u16(kToolOutputs).f32(word), reply))
      return false;
  } else {
    UxData data;
    if (at >= kHalf) data.u16(0);
    const std::size_t bit = at % kHalf;
    data.u16(0x0100u << bit | (on ? 1u : 0u) << bit);
    if (!ask_service(Register::set_digital, data, reply)) return false;
  }
  if (!(reply->bits & kInvalidBit)) return true;
  note(Cause::signal_refused, static_cast<int>(at < kMostSignals ? at : at - kMostSignals));
  return false;
}

/// Only what changed is written: somebody may have switched the others in UFACTORY Studio.
bool Link::write_outputs() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  for (std::size_t at = 0; at < wanted_.digital.size(); ++at) {
    if (!std::isfinite(wanted_.digital[at])) continue;
    const double wanted = wanted_.digital[at] > 0.5 ? 1 : 0;
    if (wanted == written_.digital[at]) continue;
    if (!write_output(at, wanted > 0.5)) return false;
    written_.digital[at] = wanted;
  }
  return true;
}

bool Link::read_signals() {
  if (settings_.inputs.count + settings_.outputs.count == 0) return true;
  std::optional<UxReply> reply;
  if (!ask_service(Register::io_state, {}, reply)) return false;
  if (reply->data.size() < kIoOutputs + 2) {
    note(Cause::bad_data);
    return false;
  }
  const auto word = [&](std::size_t place) {
    return static_cast<std::uint32_t>(reply->data[place] << 8 | reply->data[place + 1]);
  };
  current_panel_.inputs = word(kIoInputs);
  current_panel_.outputs = word(kIoOutputs);
  return true;
}

bool Link::read_tool() {
  const auto read = [this](std::uint16_t address, std::uint32_t& into) {
    std::optional<UxReply> reply;
    if (!ask_service(Register::tool_read, UxData().u8(kTool).u16(address), reply)) return false;
    if (reply->data.size() >= 4) into = reply->data[3];
    return true;
  };
  return (!settings_.tool_inputs || read(kToolInputs, current_panel_.tool_inputs)) &&
         (!settings_.tool_outputs || read(0x0A18, current_panel_.tool_outputs));
}

bool Link::serve_round() {
  std::optional<UxReply> reply;
  if (!write_outputs() || !read_signals() || !read_tool() || !ask_service(Register::get_error, {}, reply))
    return false;
  if (reply->data.size() < 2) {
    note(Cause::bad_data);
    return false;
  }
  current_panel_.error = reply->data[0];
  current_panel_.warning = reply->data[1];
  panels_.write(current_panel_);
  return true;
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

/// The controller does not take commands: an error, somebody's stop, or motors that are off.
Link::Why Link::explain_stop() {
  const std::lock_guard lock(services_mutex_);
  const auto codes = services_port_.ask(Register::get_error, {}, settings_.timeout);
  if (!codes || codes->data.size() < 2) return {codes ? Cause::bad_data : services_port_.failure().cause, 0};
  current_panel_.error = codes->data[0];
  current_panel_.warning = codes->data[1];
  panels_.write(current_panel_);
  if (codes->data[0] != 0) return {cause_of_error(codes->data[0]), codes->data[0]};
  const auto state = services_port_.ask(Register::get_state, {}, settings_.timeout);
  if (!state || state->data.empty()) return {state ? Cause::bad_data : services_port_.failure().cause, 0};
  if (state->data[0] == static_cast<int>(State::paused)) return {Cause::paused, 0};
  if (!ready_state(state->data[0])) return {Cause::stopped, state->data[0]};
  return {Cause::not_ready, 0};
}

}  // namespace polyarm::xarm
