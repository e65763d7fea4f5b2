#include "drivers/xarm/panel_port.hpp"

#include <cmath>
#include <limits>

#include "drivers/xarm/report.hpp"

namespace polyarm::xarm {

namespace {

constexpr int kAllJoints = 8;
constexpr int kTool = 9;  // the board at the tool
constexpr std::uint16_t kToolInputs = 0x0A14, kToolOutputs = 0x0A15, kToolSet = 0x0A18;
constexpr std::size_t kIoInputs = 4, kIoOutputs = 8;  // places in the state of the signals
constexpr std::size_t kHalf = 8;                      // signals in one word

}  // namespace

Outputs::Outputs() noexcept {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

bool PanelPort::fail(Cause cause, int detail, std::string text) {
  failure_ = {cause, detail, std::move(text)};
  return false;
}

std::optional<UxReply> PanelPort::ask(Register reg, const std::vector<std::uint8_t>& data) {
  auto reply = port_.ask(reg, data, timeout_);
  if (!reply) fail(port_.failure().cause, 0, port_.failure().text);
  return reply;
}

/// A word has eight signals: which ones are written, and their values.
bool PanelPort::write_one(std::size_t at, bool on) {
  std::optional<UxReply> reply;
  if (at >= kMostSignals) {
    const std::size_t bit = at - kMostSignals;
    const double word = static_cast<double>(0x0100u << bit | (on ? 1u : 0u) << bit);
    reply = ask(Register::tool_write, UxData().u8(kTool).u16(kToolOutputs).f32(word));
  } else {
    UxData data;
    if (at >= kHalf) data.u16(0);
    const std::size_t bit = at % kHalf;
    data.u16(0x0100u << bit | (on ? 1u : 0u) << bit);
    reply = ask(Register::set_digital, data);
  }
  if (!reply) return false;
  return !(reply->bits & kInvalidBit) ||
         fail(Cause::signal_refused, static_cast<int>(at < kMostSignals ? at : at - kMostSignals));
}

bool PanelPort::write(const Outputs& outputs) {
  for (std::size_t at = 0; at < outputs.digital.size(); ++at) {
    if (!std::isfinite(outputs.digital[at])) continue;
    const double wanted = outputs.digital[at] > 0.5 ? 1 : 0;
    if (wanted == written_.digital[at]) continue;
    if (!write_one(at, wanted > 0.5)) return false;
    written_.digital[at] = wanted;
  }
  return true;
}

bool PanelPort::read_tool(std::uint16_t address, std::uint32_t& into) {
  const auto reply = ask(Register::tool_read, UxData().u8(kTool).u16(address));
  if (reply && reply->data.size() >= 4) into = reply->data[3];
  return reply.has_value();
}

bool PanelPort::read_signals(Panel& into) {
  if (used_.inputs.count + used_.outputs.count > 0) {
    const auto reply = ask(Register::io_state);
    if (!reply) return false;
    if (reply->data.size() < kIoOutputs + 2) return fail(Cause::bad_data);
    const auto word = [&](std::size_t place) {
      return static_cast<std::uint32_t>(reply->data[place] << 8 | reply->data[place + 1]);
    };
    into.inputs = word(kIoInputs);
    into.outputs = word(kIoOutputs);
  }
  return !used_.tool || (read_tool(kToolInputs, into.tool_inputs) && read_tool(kToolSet, into.tool_outputs));
}

bool PanelPort::read_codes(Panel& into) {
  const auto reply = ask(Register::get_error);
  if (!reply) return false;
  if (reply->data.size() < 2) return fail(Cause::bad_data);
  into.error = reply->data[0];
  into.warning = reply->data[1];
  return true;
}

bool PanelPort::set(Register reg, unsigned value) {
  const auto reply = ask(reg, UxData().u8(value));
  if (!reply) return false;
  return !(reply->bits & kInvalidBit) || fail(Cause::request_refused, static_cast<int>(reg));
}

bool PanelPort::fail_with_error(Cause without_one) {
  Panel now;
  if (!read_codes(now)) return false;
  return now.error != 0 ? fail(cause_of_error(now.error), now.error) : fail(without_one);
}

bool PanelPort::clear(bool may_clear_errors) {
  Panel now;
  if (!read_codes(now)) return false;
  if (now.error == 0 && now.warning == 0) return true;
  if (now.error != 0 && !may_clear_errors) return fail(Cause::error_pending, now.error);
  if (!ask(Register::clean_warning) || (now.error != 0 && !ask(Register::clean_error)) || !read_codes(now))
    return false;
  return now.error == 0 || fail(cause_of_error(now.error), now.error);
}

bool PanelPort::enable_motors() {
  const auto reply = ask(Register::motion_enable, UxData().u8(kAllJoints).u8(1));
  if (!reply) return false;
  return !(reply->bits & (kErrorBit | kInvalidBit)) || fail_with_error(Cause::enable_refused);
}

PanelPort::Why PanelPort::explain_stop(Panel& into) {
  if (!read_codes(into)) return failure_;
  if (into.error != 0) return {cause_of_error(into.error), into.error, {}};
  const auto state = ask(Register::get_state);
  if (!state) return failure_;
  if (state->data.empty()) return {Cause::bad_data, 0, {}};
  const int now = state->data[0];
  if (now == static_cast<int>(State::paused)) return {Cause::paused, 0, {}};
  if (now > static_cast<int>(State::standing)) return {Cause::stopped, now, {}};
  return {Cause::not_ready, 0, {}};
}

}  // namespace polyarm::xarm
