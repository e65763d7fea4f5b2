#include "drivers/fanuc/rmi_link.hpp"

#include <algorithm>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

namespace {
constexpr Nanoseconds kServoPower = 2'000'000'000;
constexpr Nanoseconds kPause = 50'000'000;
}  // namespace

bool RmiLink::connect_rmi(const std::string& host, int port, bool streams) {
  std::string why;
  int error = 0;
  for (const char* greeting : {"FRC_Connect_STMO", "FRC_Connect"}) {
    if (!streams && greeting == std::string("FRC_Connect_STMO")) continue;
    if (rmi_.open(host, port, greeting, answer_timeout_, why, error)) return true;
    if (error != kRmiBadCommand && error != kRmiFailed) break;
  }
  if (error == kRmiConnected) return refuse(Cause::rmi_busy);
  if (error != 0) return refuse(Cause::rmi_refused, error, "a remote session");
  return refuse(Cause::unreachable, 0, why);
}

std::optional<RmiMessage> RmiLink::command_of(const char* name, const RmiLine& line) {
  auto answer = rmi_.ask("Command", name, line, answer_timeout_);
  if (!answer) refuse(Cause::rmi_silent, 0, name);
  return answer;
}

bool RmiLink::refuse_alarm(Cause otherwise) {
  const auto answer = command_of("FRC_ReadError", RmiLine("Command", "FRC_ReadError").number("Count", 1));
  const std::string alarm = answer ? answer->text("ErrorData") : std::string();
  const Cause cause = cause_of_alarm(alarm);
  return refuse(cause == Cause::none ? otherwise : cause, 0, alarm.starts_with("No Error") ? "" : alarm);
}

bool RmiLink::clear_alarms(Nanoseconds timeout) {
  if (!command_of("FRC_Abort") || !command_of("FRC_Reset")) return false;
  const Nanoseconds deadline = realtime::monotonic_now() + std::min(kServoPower, timeout);
  for (;;) {
    const auto answer = command_of("FRC_GetStatus");
    if (!answer) return false;
    if (answer->number("ServoReady") != 0) return true;
    if (realtime::monotonic_now() > deadline) return refuse_alarm(Cause::servo_off);
    wire::wait_readable(wake_.number(), kPause);
  }
}

bool RmiLink::initialize() {
  const auto answer =
      command_of("FRC_Initialize", RmiLine("Command", "FRC_Initialize").number("GroupMask", 1));
  if (!answer) return false;
  return answer->error() == 0 ? true : refuse(Cause::rmi_refused, answer->error(), "to begin remote motion");
}

}  // namespace polyarm::fanuc
