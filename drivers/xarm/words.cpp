#include "drivers/xarm/words.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <iterator>

#include "drivers/watchdog/link.hpp"
#include "drivers/wire/words.hpp"
#include "drivers/xarm/watchdog.hpp"

namespace polyarm::xarm {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "unreachable",
                                    "command-silent",
                                    "report-silent",
                                    "bad-data",
                                    "closed",
                                    "wrong-axes",
                                    "old-firmware",
                                    "wrong-rate",
                                    "emergency-stop",
                                    "joint-error",
                                    "collision",
                                    "self-collision",
                                    "joint-limit",
                                    "kinematics",
                                    "speed-limit",
                                    "planning",
                                    "boundary",
                                    "tool-error",
                                    "force-sensor",
                                    "controller-error",
                                    "error-pending",
                                    "enable-refused",
                                    "mode-refused",
                                    "state-refused",
                                    "mode-changed",
                                    "paused",
                                    "stopped",
                                    "not-ready",
                                    "command-refused",
                                    "request-refused",
                                    "signal-refused",
                                    "moves",
                                    "too-fast",
                                    "loop-silent",
                                    "jump",
                                    "joint-commands",
                                    "moves-refused",
                                    "off-target",
                                    "tool-differs",
                                    "halt-unconfirmed",
                                    "watchdog"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Cause::watchdog) + 1);
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

constexpr const char* kRecover = "; then recover here";

/// Connections and their data.
std::string wire_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::unreachable:
      return where + ": " + text + "; `polyarm setup xarm` looks for it";
    case Cause::command_silent:
      return where +
             " does not answer a request: check cable and power, restart the control box if it stays so";
    case Cause::report_silent:
      return where + " sends no reports any more: check cable, power and network load";
    case Cause::bad_data:
      return where +
             " sent what is no frame of a controller of UFACTORY: check the address and the ports "
             "`command_port` and `report_port`";
    case Cause::closed:
      return where +
             " closed a connection: it was switched off or restarted, or its software was; wait until it "
             "runs, "
             "then recover here";
    case Cause::wrong_axes:
      return where + " drives an arm with " + std::to_string(detail) +
             " axes, and the robot of the cell has another number: choose its `model`, or name its joints in "
             "a <ros2_control> block";
    case Cause::old_firmware:
      return where + " has firmware " + text + ", which is older than 1.5: update it in UFACTORY Studio";
    case Cause::wrong_rate:
      return where + " would need another rate of the cell, " + std::to_string(detail) + " Hz: change `rate`";
    case Cause::request_refused:
      return where + " refused a request (register " + std::to_string(detail) +
             "): look at UFACTORY Studio for an error, and for newer firmware";
    case Cause::signal_refused:
      return where + " does not switch the output " + std::to_string(detail) +
             ": check its number, and that UFACTORY Studio gives it no function of its own";
    default:
      return {};
  }
}

/// "… has error C31: currents were …; then recover here".
std::string error_sentence(Cause cause, int code, const std::string& where) {
  const std::string what = fmt::format(" (C{}): {}{}", code, error_words(code), kRecover);
  switch (cause) {
    case Cause::emergency_stop:
      return where + " is in an emergency stop" + what;
    case Cause::joint_error:
      return where + " has an error of a joint" + what;
    case Cause::collision:
      return where + " stopped for a collision" + what;
    case Cause::self_collision:
      return where + " stopped before a collision of the robot with itself" + what;
    case Cause::joint_limit:
      return where + " stopped at a limit of a joint" + what;
    case Cause::kinematics:
      return where + " has no solution for a target" + what;
    case Cause::speed_limit:
      return where + " stopped because a motion was too fast" + what;
    case Cause::planning:
      return where + " could not plan" + what;
    case Cause::boundary:
      return where + " stopped at its safety boundary" + what;
    case Cause::tool_error:
      return where + " has an error of a device at the tool" + what;
    case Cause::force_sensor:
      return where + " has an error of its force sensor" + what;
    case Cause::controller_error:
      return where + " has an error of its own" + what;
    case Cause::error_pending:
      return where +
             fmt::format(
                 " has an error, and `clear_errors` is false (C{}): {}; clear it in UFACTORY Studio{}", code,
                 error_words(code), kRecover);
    default:
      return {};
  }
}

/// Modes and states.
std::string state_sentence(Cause cause, int detail, const std::string& where) {
  switch (cause) {
    case Cause::enable_refused:
      return where +
             " does not switch the motors on: look at UFACTORY Studio for the reason, and check the "
             "emergency "
             "stops";
    case Cause::mode_refused:
      return where +
             fmt::format(
                 " does not take {} mode: end other programs that use it, and look at UFACTORY Studio",
                 mode_words(detail));
    case Cause::state_refused:
      return where + " does not become ready for motion: look at UFACTORY Studio for the reason";
    case Cause::mode_changed:
      return where + fmt::format(
                         " was switched to mode {} ({}) by somebody else: end that program, or leave manual "
                         "mode in UFACTORY Studio{}",
                         detail, mode_words(detail), kRecover);
    case Cause::paused:
      return where + " was paused: look who did it in UFACTORY Studio or at a signal" + kRecover;
    case Cause::stopped:
      return where + fmt::format(
                         " was stopped without an error (state {}): by the stop button of UFACTORY Studio, "
                         "by a signal, or by another program; look why{}",
                         detail, kRecover);
    case Cause::not_ready:
      return where +
             " does not take commands: its motors are off or it is not ready; look at UFACTORY Studio" +
             kRecover;
    case Cause::command_refused:
      return where + " refused a servo command as invalid: check that firmware and `model` fit";
    case Cause::moves:
      return "the robot of " + where +
             " moves though nothing was commanded here: end the program or client that moves it, then "
             "activate "
             "again";
    default:
      return {};
  }
}

/// Moves that the controller interpolates.
std::string forward_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
    case Cause::moves_refused:
      return where + " takes no move" +
             (detail != 0 ? fmt::format(" (W{}: {})", detail, warning_words(detail)) : std::string()) +
             ": check that firmware and `model` fit, and end other clients that command it" + kRecover;
    case Cause::off_target:
      return "the robot of " + where +
             fmt::format(
                 " is not where its move ended (joint {}): compare its angles here and in UFACTORY "
                 "Studio, and end other clients that command it",
                 detail + 1) +
             kRecover;
    case Cause::tool_differs:
      return where +
             fmt::format(
                 " has its TCP {} mm away from that of the cell ({}): compare `model`, mounting and "
                 "base offset with UFACTORY Studio",
                 detail, text) +
             kRecover;
    case Cause::halt_unconfirmed:
      return where +
             " does not say that it stopped the robot: look at UFACTORY Studio, restart the control box if "
             "it stays so" +
             kRecover;
    case Cause::watchdog: {
      const watchdog::Names names{kWatchdogProgram,
                                  where,
                                  "a connection to " + where,
                                  "the robot was stopped",
                                  "stopped the robot of " + where,
                                  std::atoi(text.c_str())};
      return "the driver of " + where + ": " + sentence(static_cast<watchdog::Health>(detail), names);
    }
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  if (cause == Cause::none) return {};
  if (std::string out = wire_sentence(cause, detail, where, text); !out.empty()) return out;
  if (std::string out = error_sentence(cause, detail, where); !out.empty()) return out;
  if (std::string out = state_sentence(cause, detail, where); !out.empty()) return out;
  if (std::string out = forward_sentence(cause, detail, where, text); !out.empty()) return out;
  switch (cause) {
    case Cause::too_fast:
      return wire::too_fast_sentence(detail, where) + ", or raise `max_speed`";
    case Cause::loop_silent:
      return wire::loop_silent_sentence(where);
    case Cause::jump:
      return wire::jump_sentence(detail, where);
    default:
      return {};
  }
}

}  // namespace polyarm::xarm
