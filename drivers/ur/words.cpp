#include "drivers/ur/words.hpp"

#include <iterator>

#include "drivers/wire/words.hpp"

namespace polyarm::ur {

const char* robot_mode_name(int mode) {
  constexpr const char* kNames[] = {"NO_CONTROLLER", "DISCONNECTED",     "CONFIRM_SAFETY", "BOOTING",
                                    "POWER_OFF",     "POWER_ON",         "IDLE",           "BACKDRIVE",
                                    "RUNNING",       "UPDATING_FIRMWARE"};
  return mode >= -1 && mode <= 8 ? kNames[mode + 1] : "UNKNOWN";
}

const char* safety_mode_name(int mode) {
  constexpr const char* kNames[] = {"NORMAL",
                                    "REDUCED",
                                    "PROTECTIVE_STOP",
                                    "RECOVERY",
                                    "SAFEGUARD_STOP",
                                    "SYSTEM_EMERGENCY_STOP",
                                    "ROBOT_EMERGENCY_STOP",
                                    "VIOLATION",
                                    "FAULT",
                                    "VALIDATE_JOINT_ID",
                                    "UNDEFINED_SAFETY_MODE",
                                    "AUTOMATIC_MODE_SAFEGUARD_STOP",
                                    "SYSTEM_THREE_POSITION_ENABLING_STOP",
                                    "TP_THREE_POSITION_ENABLING_STOP"};
  return mode >= 1 && mode <= static_cast<int>(std::size(kNames)) ? kNames[mode - 1] : "UNKNOWN";
}

const char* name(Cause cause) {
  constexpr const char* kNames[] = {
      "none",           "unreachable",    "wrong-version",   "too-old",         "missing-value",
      "second-client",  "not-remote",     "robot-mode",      "protective-stop", "safeguard-stop",
      "emergency-stop", "safety-fault",   "program-stopped", "program-paused",  "script-error",
      "no-answer-back", "reverse-closed", "commands-late",   "loop-silent",     "jump",
      "rtde-silent",    "rtde-closed",    "bad-data",        "not-reading",     "other-program",
      "wrong-rate",     "off-target",     "joint-commands"};
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

std::string mode_sentence(int mode) {
  switch (mode) {
    case power_off:
      return "the robot is switched off; switch it on and release its brakes at its pendant, then activate "
             "again";
    case idle:
      return "the robot is on and its brakes are closed; release them at its pendant, then activate again";
    case booting:
      return "the robot is still starting; wait, then activate again";
    case confirm_safety:
      return "the robot waits until somebody confirms its safety configuration at its pendant";
    case backdrive:
      return "the robot is being moved by hand; end that at its pendant, then activate again";
    default:
      return std::string("the robot is in the mode ") + robot_mode_name(mode) +
             "; bring it to RUNNING at its pendant, then activate again";
  }
}

std::string quoted(const std::string& text) {
  return text.empty() ? "" : " (it says: " + text + ")";
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::none:
      return {};
    case Cause::unreachable:
      return where + ": " + text;
    case Cause::wrong_version:
      return where +
             " refuses RTDE protocol 2 and 1: is that a controller of Universal Robots, with software 3.5 or "
             "newer?";
    case Cause::too_old:
      return where + " has software " + text + "; this driver needs 3.5 or newer: update the controller";
    case Cause::missing_value:
      return where + " does not offer the value " + text + " over RTDE; update the controller's software";
    case Cause::second_client:
      return "another program already writes " + text + " of " + where +
             " over RTDE: end that program or disable the fieldbus that uses it, or set `io: false` here";
    case Cause::not_remote:
      return where +
             " is in local control; choose remote control at its pendant (top right), then activate again" +
             quoted(text);
    case Cause::robot_mode:
      return where + ": " + mode_sentence(detail);
    case Cause::protective_stop:
      return where +
             " made a protective stop: look what the arm touched or which limit it met, wait 5 s, choose "
             "\"Enable robot\" at its pendant, then recover here" +
             quoted(text);
    case Cause::safeguard_stop:
      return where +
             " is in a safeguard stop: clear the guarded area and reset the safeguard, then recover here";
    case Cause::emergency_stop:
      return where +
             " is in an emergency stop: make sure that nobody is in danger, release the button, switch the "
             "robot on and release its brakes, then recover here";
    case Cause::safety_fault:
      return where + " reports the safety mode " + safety_mode_name(detail) +
             ": read the log at its pendant and restart its safety system, then recover here";
    case Cause::program_stopped:
      return "the program on " + where +
             " was stopped there, by hand or by another program; recover here to start "
             "it again" +
             quoted(text);
    case Cause::program_paused:
      return "the program on " + where + " was paused there; stop it at the pendant, then recover here";
    case Cause::script_error:
      return "the program on " + where + " ended with an error" + quoted(text) +
             "; report it with the text of "
             "the robot's log";
    case Cause::no_answer_back:
      return "the program on " + where + " runs, but does not connect to this computer at " + text +
             ": open that port in this computer's firewall, or set `own_address` to the address that the "
             "robot "
             "reaches";
    case Cause::reverse_closed:
      return "the program on " + where +
             " closed its connection, and says nothing about the cause; read the log at "
             "its pendant, then recover here";
    case Cause::commands_late:
      return "the program on " + where +
             " got no command in time and stopped the robot: this computer or the "
             "network was too slow; use a cable instead of wireless, give the loop a priority, or raise "
             "`watchdog_ms`";
    case Cause::loop_silent:
      return "the control loop gave no command in time, and the driver stopped the robot at " + where +
             "; see `polyarm health` for the reason, then recover here";
    case Cause::jump:
      return "a command for " + (detail < 0 ? "a joint" : "joint " + std::to_string(detail + 1)) +
             " of the robot at " + where +
             " is too far away for one cycle; it was not carried out, and the robot was stopped: check "
             "controllers and "
             "limits";
    case Cause::other_program:
      return where + (detail == paused ? " has a paused program" : " runs another program") +
             ": stop it at the pendant, then activate again";
    case Cause::rtde_silent:
      return where +
             " sends nothing any more: check cable, switch and power of the controller; the robot's program "
             "stops the robot by itself";
    case Cause::rtde_closed:
      return where +
             " closed the RTDE connection: it restarts, was switched off, or this computer read too slowly";
    case Cause::bad_data:
      return where +
             " sent data that is no RTDE: check that the port is 30004 and that nothing in between changes "
             "the stream" +
             quoted(text);
    case Cause::not_reading:
      return "the program on " + where + " does not read its commands; recover here to start it again";
    case Cause::wrong_rate:
      return where + " runs at " + std::to_string(detail) +
             " Hz, and the cell at another rate: write `rate: " + std::to_string(detail) +
             "` into the cell, or set `pace: false`";
    case Cause::off_target:
      return where + " reports the end of a move, but joint " + std::to_string(detail + 1) +
             " is elsewhere: compare the angles here and at its pendant, then recover here";
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
  }
  return {};
}

Obstacle obstacle_of(int robot, int safety) noexcept {
  switch (safety) {
    case safety_normal:
    case safety_reduced:
      break;
    case protective_stop:
      return {Cause::protective_stop, safety};
    case safeguard_stop:
    case 12:  // automatic mode safeguard stop
    case 16:
    case 18:
    case 19:
    case 22:
      return {Cause::safeguard_stop, safety};
    case system_emergency:
    case robot_emergency:
    case 15:
    case 20:
      return {Cause::emergency_stop, safety};
    default:
      return {Cause::safety_fault, safety};
  }
  if (robot != running) return {Cause::robot_mode, robot};
  return {};
}

}  // namespace polyarm::ur
