#include "drivers/yaskawa/words.hpp"

#include <fmt/format.h>

#include <iterator>

#include "drivers/wire/words.hpp"
#include "drivers/yaskawa/moto.hpp"

namespace polyarm::yaskawa {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "unreachable",
                                    "hses-silent",
                                    "hses-bad-data",
                                    "hses-refused",
                                    "moto-silent",
                                    "state-silent",
                                    "bad-data",
                                    "closed",
                                    "other-client",
                                    "no-group",
                                    "wrong-rate",
                                    "alarm",
                                    "error",
                                    "emergency-stop",
                                    "teach-mode",
                                    "not-remote",
                                    "servo-off",
                                    "servo-refused",
                                    "hold",
                                    "not-started",
                                    "waiting-ros",
                                    "skill-send",
                                    "pfl",
                                    "increment-refused",
                                    "not-ready",
                                    "moves",
                                    "start-position",
                                    "speed-refused",
                                    "point-refused",
                                    "moto-failed",
                                    "points-late",
                                    "points-stuck",
                                    "too-long",
                                    "signal-refused",
                                    "too-fast",
                                    "loop-silent",
                                    "jump",
                                    "no-watchdog",
                                    "job-runs",
                                    "job-version",
                                    "job-stopped",
                                    "tool-number",
                                    "tool-differs",
                                    "moves-changed",
                                    "hold-ignored",
                                    "halt-unconfirmed",
                                    "off-target",
                                    "joint-commands"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Cause::joint_commands) + 1);
  return kNames[static_cast<std::size_t>(cause)];
}

Why why_not(int result, int subcode) {
  switch (static_cast<NotReady>(subcode)) {
    case NotReady::alarm:
      return {Cause::alarm, 0};
    case NotReady::error:
      return {Cause::error, 0};
    case NotReady::e_stop:
      return {Cause::emergency_stop, 0};
    case NotReady::not_play:
      return {Cause::teach_mode, 0};
    case NotReady::not_remote:
      return {Cause::not_remote, 0};
    case NotReady::servo_off:
      return {Cause::servo_off, 0};
    case NotReady::hold:
      return {Cause::hold, 0};
    case NotReady::not_started:
      return {Cause::not_started, 0};
    case NotReady::waiting_ros:
      return {Cause::waiting_ros, 0};
    case NotReady::skill_send:
      return {Cause::skill_send, 0};
    case NotReady::pfl_active:
      return {Cause::pfl, 0};
    case NotReady::increment_error:
      return {Cause::increment_refused, 0};
    default:
      break;
  }
  switch (static_cast<Invalid>(subcode)) {
    case Invalid::start_position:
      return {Cause::start_position, 0};
    case Invalid::speed:
      return {Cause::speed_refused, 0};
    default:
      break;
  }
  switch (static_cast<MotoResult>(result)) {
    case MotoResult::invalid:
      return {Cause::point_refused, subcode};
    case MotoResult::alarm:
      return {Cause::alarm, 0};
    case MotoResult::not_ready:
      return {Cause::not_ready, subcode};
    default:
      return {Cause::moto_failed, result};
  }
}

namespace {

std::string with(const std::string& text) {
  return text.empty() ? "" : " (" + text + ")";
}

/// What an added status of HSES means.
std::string hses_reason(int detail) {
  switch (detail) {
    case 0x08:
      return "it does not know the command";
    case 0x09:
      return "it has no such element";
    case 0x28:
      return "it has no such instance";
    case 0x2010:
      return "the robot moves; wait for its end";
    case 0x2020:
      return "it is in hold from the pendant; release it there";
    case 0x2030:
      return "it is in hold from outside; release that signal";
    case 0x2040:
      return "it is in hold by a command; release it";
    case 0x2060:
      return "an alarm or error is there; reset it";
    case 0x2070:
      return "the servos are off; switch them on";
    case 0x2080:
      return "it is in the wrong mode; choose play and remote";
    case 0x2090:
      return "another application has the file; end that";
    case 0x2100:
      return "remote commands are not allowed; allow them in its menu for pseudo inputs";
    case 0x2110:
      return "the data is in use; try again";
    case 0x3220:
      return "the job is locked; unlock it at the pendant";
    case 0x4040:
      return "there is no such job; load it first";
    default:
      return fmt::format("status {:X}; look at its manual for the Ethernet server", detail);
  }
}

std::string too_fast(int detail, const std::string& where) {
  return wire::too_fast_sentence(detail, where) + ", or raise `max_speed`";
}

/// Connections and their data.
std::string wire_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::unreachable:
      return where + ": " + text +
             "; MotoROS must be loaded and running (output 892), `polyarm setup yaskawa` looks for it";
    case Cause::hses_silent:
      return where +
             " does not answer at UDP port 10040: switch the Ethernet server on in its maintenance mode, "
             "check "
             "the address, and that no firewall blocks UDP; or write `hses: false`";
    case Cause::hses_bad_data:
      return where + " sent what is no answer of its Ethernet server: check `hses_port` and the address";
    case Cause::hses_refused:
      return "the Ethernet server of " + where + " refused: " + hses_reason(detail);
    case Cause::moto_silent:
      return "MotoROS of " + where +
             " does not answer: check cable and power; restart the controller if it stays so";
    case Cause::state_silent:
      return "MotoROS of " + where + " sends no states any more: check cable, power and network load";
    case Cause::bad_data:
      return where +
             " sent what is no message of MotoROS: check the ports, and that the version of MotoROS is that "
             "of "
             "ROS-Industrial (MotoROS 2 speaks otherwise)";
    case Cause::closed:
      return "MotoROS of " + where +
             " closed a connection: the controller was switched off or restarted, or another client "
             "connected "
             "while the robot stood; end that client, then recover here";
    case Cause::other_client:
      return "MotoROS of " + where +
             " closed a new connection at once: another client moves the robot; end that one first";
    case Cause::no_group:
      return where + " sends no positions of control group " + std::to_string(detail) +
             ": write the `group` of the robot, counted from 0";
    case Cause::wrong_rate:
      return where + " would need another rate of the cell, " + std::to_string(detail) + " Hz: change `rate`";
    case Cause::signal_refused:
      return where + " does not take or give the signal " + std::to_string(detail) +
             ": check its number in `digital_in` or `digital_out`";
    default:
      return {};
  }
}

/// What a person sees at the pendant.
std::string state_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  constexpr const char* kHolds[] = {"", ", by the button of the pendant", ", by a signal from outside",
                                    ", by a command"};
  switch (cause) {
    case Cause::alarm:
      return where + " has alarm " + std::to_string(detail) + with(text) +
             ": remove its cause, reset it at the pendant, then recover here";
    case Cause::error:
      return where + " shows an error" + with(text) + ": cancel it at the pendant, then recover here";
    case Cause::emergency_stop:
      return where +
             " is in an emergency stop (pendant, cabinet or outside): look why, release the button, then "
             "recover here";
    case Cause::teach_mode:
      return where + " is in teach mode: turn the key of the pendant to REMOTE, then recover here";
    case Cause::not_remote:
      return where +
             " is in play mode without remote: turn the key of the pendant to REMOTE, then recover here";
    case Cause::servo_off:
      return "the servos of " + where +
             " are off: look why (an emergency stop, a guard, an enabling switch), then recover here";
    case Cause::servo_refused:
      return "the servos of " + where +
             " do not switch on: look at the pendant for the message, check guards and safety signals";
    case Cause::hold:
      return where + " is in hold" + kHolds[detail >= 0 && detail <= 3 ? detail : 0] +
             ": release it, then recover here";
    case Cause::not_started:
      return "the job INIT_ROS of " + where +
             " does not run: it was stopped there, or it is not loaded; look why, then recover here to start "
             "it again";
    case Cause::waiting_ros:
      return "the job INIT_ROS of " + where +
             " runs and does not wait for MotoROS (output 889): load the job of your controller anew";
    case Cause::skill_send:
      return where + " (DX100) does not wait at its SKILLSND command: load its jobs ROS_R1 or ROS_S1 anew";
    case Cause::pfl:
      return where +
             " stopped because the robot was touched or pushed (power and force limiting): look why, "
             "clear the space, then recover here";
    case Cause::increment_refused:
      return where +
             " refused a step of the motion: look at its pendant for the cause, often a limit or an "
             "interference area, then recover here";
    case Cause::not_ready:
      return where + " does not allow motion (subcode " + std::to_string(detail) +
             " of MotoROS): look at its pendant";
    case Cause::moves:
      return "the robot of " + where +
             " moves though nothing was commanded here: end the job or client that "
             "moves it, then activate again";
    default:
      return {};
  }
}

/// Points, the loop and its commands.
std::string motion_sentence(Cause cause, int detail, const std::string& where) {
  switch (cause) {
    case Cause::start_position:
      return where +
             " stands more than 30 pulses away from the first point: somebody moved it meanwhile; "
             "recover here, which begins where it stands";
    case Cause::speed_refused:
      return where + " refused a point that is faster than an axis may be: lower `max_speed`";
    case Cause::point_refused:
      return where + " refused a point (subcode " + std::to_string(detail) +
             " of MotoROS): check `group`, and the version of MotoROS";
    case Cause::moto_failed:
      return "MotoROS of " + where + " could not do what was asked (result " + std::to_string(detail) +
             "): look at the pendant, restart the controller if it stays so";
    case Cause::points_late:
      return where +
             " ran out of points while the robot moved: use a cable, keep other load off this "
             "computer, or raise `lead_ms`";
    case Cause::points_stuck:
      return where +
             " takes no points any more (busy): look at its pendant for a speed limit or a stop, then "
             "recover here";
    case Cause::too_long:
      return where +
             " was commanded for hours without a rest, longer than MotoROS allows (4 h): let the program "
             "stand for a second now and then";
    case Cause::too_fast:
      return too_fast(detail, where);
    case Cause::loop_silent:
      return wire::loop_silent_sentence(where);
    case Cause::jump:
      return wire::jump_sentence(detail, where);
    default:
      return {};
  }
}

/// The job POLYARM, its variables and moves.
std::string forward_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::no_watchdog:
      return where +
             " does not hold the robot when the heartbeat of this computer stops, so nothing is started: "
             "write the rungs of `polyarm setup yaskawa --motion forward --write FOLDER` into its ladder, "
             "check `heartbeat_byte`";
    case Cause::job_runs:
      return where + " runs the job " + (text.empty() ? "of somebody else" : text) +
             ": end it at the pendant, then activate again";
    case Cause::job_version:
      return "the job POLYARM of " + where + " has version " + std::to_string(detail) +
             ", not that of this program: load the one of `polyarm setup yaskawa --motion forward --write "
             "FOLDER`";
    case Cause::job_stopped:
      return "the job POLYARM of " + where +
             " was stopped there: look why, then recover here to start it again";
    case Cause::tool_number:
      return where + " has tool " + std::to_string(detail) + " selected, and " + text +
             " is wanted: select that one at the pendant, or change `tool_number`";
    case Cause::tool_differs:
      return where + " has its TCP " + std::to_string(detail) + " mm away from that of this cell (" + text +
             "): check `pulses`, `base_height`, the model, and the tool file at the pendant";
    case Cause::moves_changed:
      return "somebody else changes the variables of the job POLYARM of " + where +
             " (D080 to D087): end the job or client that does it, then recover here";
    case Cause::hold_ignored:
      return where +
             " does not stop its job when it is held; the heartbeat was ended, which stops the robot: look "
             "at the pendant, then recover here";
    case Cause::halt_unconfirmed:
      return "the robot of " + where +
             " did not come to rest after a hold: look at the pendant, then recover here";
    case Cause::off_target:
      return "the robot of " + where + " stands, and joint " + std::to_string(detail + 1) +
             " is not where its move ends: check `pulses`, and what the pendant says";
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  if (cause == Cause::none) return {};
  if (std::string out = wire_sentence(cause, detail, where, text); !out.empty()) return out;
  if (std::string out = state_sentence(cause, detail, where, text); !out.empty()) return out;
  if (std::string out = forward_sentence(cause, detail, where, text); !out.empty()) return out;
  return motion_sentence(cause, detail, where);
}

}  // namespace polyarm::yaskawa
