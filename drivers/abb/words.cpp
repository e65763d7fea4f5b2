#include "drivers/abb/words.hpp"

#include <array>

#include "drivers/wire/words.hpp"

namespace polyarm::abb {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "unreachable",
                                    "tls",
                                    "certificate",
                                    "login",
                                    "forbidden",
                                    "busy",
                                    "rws-silent",
                                    "rws-bad-data",
                                    "rws-refused",
                                    "other-version",
                                    "old-software",
                                    "no-option",
                                    "no-module",
                                    "no-signal",
                                    "signal-refused",
                                    "manual-mode",
                                    "emergency-stop",
                                    "guard-stop",
                                    "motors-off",
                                    "motors-refused",
                                    "system-failure",
                                    "starting",
                                    "mastership",
                                    "start-refused",
                                    "no-packets",
                                    "not-running",
                                    "bad-data",
                                    "old-egm",
                                    "axes",
                                    "silent",
                                    "restarted",
                                    "other-sender",
                                    "program-stopped",
                                    "egm-stopped",
                                    "egm-error",
                                    "commands-late",
                                    "joint-range",
                                    "collision",
                                    "singularity",
                                    "speed",
                                    "load",
                                    "event",
                                    "too-fast",
                                    "loop-silent",
                                    "jump",
                                    "wrong-rate",
                                    "port-taken",
                                    "no-moves-module",
                                    "moves-unreachable",
                                    "moves-version",
                                    "moves-silent",
                                    "moves-closed",
                                    "moves-bad-data",
                                    "moves-refused",
                                    "moves-ended",
                                    "move-failed",
                                    "frame-differs",
                                    "joint-commands",
                                    "arc-too-long",
                                    "off-target",
                                    "halt-unconfirmed"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Cause::halt_unconfirmed) + 1);
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

std::string quoted(const std::string& text) {
  return text.empty() ? "" : " (it says: " + text + ")";
}

std::string too_fast(int detail, const std::string& where) {
  return wire::too_fast_sentence(detail, where) +
         ", or raise `max_speed` here and "
         "MaxSpeedDeviation "
         "in the RAPID module together; if cycles of the loop were late, keep other load off this computer";
}

/// Connections and Robot Web Services.
std::string service_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::unreachable:
      return where + ": " + text;
    case Cause::tls:
      return where + " does not speak TLS at this port (" + text +
             "): an IRC5 controller needs `rws: 1`, an OmniCore `rws: 2` and port 443";
    case Cause::certificate:
      return where + " shows another certificate than `fingerprint`: " + text +
             "; if the controller was reinstalled, write the new one, else somebody is in between";
    case Cause::login:
      return where + " refuses user or password of Robot Web Services: check `user` and `password_file`";
    case Cause::forbidden:
      return "the user has no right for " + text + " on " + where +
             ": give the user the grants for remote start, I/O and RAPID in the User Authorization System, "
             "and "
             "allow remote control at the FlexPendant";
    case Cause::busy:
      return where +
             " has too many sessions or requests of Robot Web Services: end other programs that use it, or "
             "wait "
             "five minutes until its old sessions end";
    case Cause::rws_silent:
      return where + " does not answer over Robot Web Services (" + text +
             "): check cable and power; if it restarts, recover here when it is ready";
    case Cause::rws_bad_data:
      return where + " sent what is no answer of Robot Web Services (" + text +
             "): check `rws_port`, and that no proxy is in between";
    case Cause::rws_refused:
      return where + " refuses " + text + " (HTTP status " + std::to_string(detail) +
             "): look into the event log on its FlexPendant";
    case Cause::other_version:
      return where + " has the other version of Robot Web Services: write `rws: " + std::to_string(detail) +
             "` (1: IRC5, RobotWare 6; 2: OmniCore, RobotWare 7)";
    case Cause::old_software:
      return where + " has RobotWare " + text +
             "; this driver needs 6.07.01 or newer: have the controller updated";
    case Cause::no_option:
      return where +
             " does not have Externally Guided Motion: the option is 689-1 (IRC5) or 3124-1 (OmniCore); buy "
             "and "
             "install it";
    case Cause::no_module:
      return "the task " + text + " of " + where +
             " does not have the module PolyarmEGM: `polyarm setup abb` writes and installs it";
    case Cause::no_signal:
      return where + " has no signal '" + text +
             "': check the spelling in `digital_in` and `digital_out`, capitals count";
    case Cause::signal_refused:
      return where + " does not let this driver write the signal '" + text +
             "': set its access level to All in the I/O configuration, and give the user the grant for I/O";
    default:
      return {};
  }
}

/// Modes, motors, safety, programs.
std::string state_sentence(Cause cause, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::manual_mode:
      return where + " is in manual mode" + quoted(text) +
             ": turn its key or choose Auto, confirm it at the FlexPendant, then recover here";
    case Cause::emergency_stop:
      return where +
             " is in an emergency stop: make sure that nobody is in danger, release the button, press Motors "
             "On "
             "once, then recover here" +
             quoted(text);
    case Cause::guard_stop:
      return "a guard of " + where +
             " is open (auto, general or superior stop): clear the guarded area and close it, then recover "
             "here" +
             quoted(text);
    case Cause::motors_off:
      return "the motors of " + where + " are off" + quoted(text) + ": switch them on, then recover here";
    case Cause::motors_refused:
      return where + " does not switch its motors on" + quoted(text) +
             ": check emergency stops and guards, and that it is in automatic mode";
    case Cause::system_failure:
      return where + " is in system failure: restart it; if it comes again, look into its event log" +
             quoted(text);
    case Cause::starting:
      return where + " is still starting: wait until its FlexPendant shows the mode, then recover here";
    case Cause::mastership:
      return "another program holds the mastership of " + where + quoted(text) +
             ": log out there (RobotStudio, another client, the FlexPendant's write access), then activate "
             "again";
    case Cause::start_refused:
      return where + " does not start its program" + quoted(text) +
             ": choose Auto, switch the motors on, release mastership elsewhere, and check that the task is "
             "enabled";
    case Cause::program_stopped:
      return "the RAPID program of " + where +
             " was stopped there, by hand or by an error of its own; recover here to start it again" +
             quoted(text);
    default:
      return {};
  }
}

/// Externally Guided Motion, and the loop behind it.
std::string motion_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::no_packets:
      return "the program of " + where +
             " runs, but no packets of EGM arrive: in its configuration (Communication, UDPUC Device) the "
             "device "
             "`Polyarm` must have the address and port of this computer" +
             (text.empty() ? "" : " (" + text + ")") + "; allow UDP in the firewall here";
    case Cause::not_running:
      return "EGM of " + where + " does not begin to follow" + quoted(text) +
             ": look for its reason in the event log of the controller";
    case Cause::bad_data:
      return where + " sent what is no packet of EGM: check that nothing else sends to this port" +
             quoted(text);
    case Cause::old_egm:
      return where + " speaks EGM of before RobotWare 6.07, whose units differ: have it updated";
    case Cause::axes:
      return where + " reports " + std::to_string(detail) +
             " joints; this driver takes robots with six, without an axis more in the same task";
    case Cause::silent:
      return where +
             " sends no packets of EGM any more: check cable and power, and that no firewall blocks UDP; its "
             "program may have ended";
    case Cause::restarted:
      return "EGM of " + where + " began anew while the robot moved: its program was started again there";
    case Cause::other_sender:
      return "another sender than " + where +
             " sends EGM to this port: give each controller its own `egm_port`";
    case Cause::egm_stopped:
      return "EGM of " + where +
             " ended though its program runs: its condition or time was met, or EGMStop was "
             "called; recover here to start it again" +
             quoted(text);
    case Cause::egm_error:
      return "EGM of " + where + " reports an error" + quoted(text) +
             ": look into its event log, then recover here";
    case Cause::commands_late:
      return where +
             " got no command in time: use a cable, give the loop priority (`priority`), and keep other load "
             "off "
             "this computer" +
             quoted(text);
    case Cause::joint_range:
      return "a joint of " + where + " reached its limit" + quoted(text) +
             ": make the limits in the cell those of the controller, jog the robot back, then recover here";
    case Cause::collision:
      return where + " stopped at a collision" + quoted(text) +
             ": look what the arm touched, free it, check payload and tool, then recover here";
    case Cause::singularity:
      return where + " stopped near a singularity" + quoted(text) +
             ": jog the robot away from it, change the path, then recover here";
    case Cause::speed:
      return "a joint of " + where + " was too fast" + quoted(text) +
             ": lower the robot's velocity limits in the cell, then recover here";
    case Cause::load:
      return "the motors of " + where + " were overloaded" + quoted(text) +
             ": check the payload that is set there, and lower the robot's acceleration in the cell";
    case Cause::event:
      return where + " stopped with event " + std::to_string(detail) + quoted(text) +
             ": look it up on its FlexPendant, remove its cause, then recover here";
    case Cause::too_fast:
      return too_fast(detail, where);
    case Cause::loop_silent:
      return wire::loop_silent_sentence(where);
    case Cause::jump:
      return wire::jump_sentence(detail, where);
    case Cause::wrong_rate:
      return where + " runs EGM at " + std::to_string(detail) +
             " Hz, and the cell at another rate: write `rate: " + std::to_string(detail) +
             "` into the cell, or set `pace: false`";
    case Cause::port_taken:
      return "the port for EGM of " + where + " cannot be opened: " + text +
             "; end the program that uses it, or change `egm_port` here and in the UDPUC device";
    default:
      return {};
  }
}

/// Forward mode.
std::string moves_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  const std::string program = "the program PolyarmMoves of " + where;
  switch (cause) {
    case Cause::no_moves_module:
      return "the task " + text + " of " + where +
             " does not have the module PolyarmMoves: `polyarm setup abb --motion forward` writes and "
             "installs it";
    case Cause::moves_unreachable:
      return program + " is not reached: " + text +
             "; check `moves_port`; IRC5: the option for sockets (PC Interface); OmniCore: RapidSockets, "
             "which its Firewall Manager must allow for this network; if the address in the module is "
             "another one, install it again with `polyarm setup abb --motion forward --install`";
    case Cause::moves_version:
      return program + " has version " + std::to_string(detail) +
             ", another one than this driver: install it again with `polyarm setup abb --motion forward "
             "--install`";
    case Cause::moves_silent:
      return program +
             " does not answer: check cable and power, and that no other client is connected to it; it takes "
             "one at a time";
    case Cause::moves_closed:
      return program + " closed the connection: it was started again there, or it ended; recover here";
    case Cause::moves_bad_data:
      return program +
             " sent what is no answer of it: check `moves_port`, and that nothing else listens there";
    case Cause::moves_refused:
      return program + " takes no move (" + std::to_string(detail) +
             "): its places are full or its session is over; recover here, which begins a new one";
    case Cause::moves_ended:
      return program +
             " ended the session by itself: no request reached it within `watchdog_ms`; use a cable, and "
             "recover here";
    case Cause::move_failed:
      return program + " could not make a move (error " + std::to_string(detail) +
             "): look into the event log of the controller, and change the target or the path";
    case Cause::frame_differs:
      return "the flange of " + where + " is elsewhere than in the cell (" + text +
             "): the robot's model must be the real one, and its base the world frame of the controller";
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
    case Cause::arc_too_long:
      return program + " cannot make an arc of " + std::to_string(detail) +
             " degrees, because MoveC of ABB takes 240 at most: make two arcs of it";
    case Cause::off_target:
      return "joint " + std::to_string(detail + 1) + " of " + where +
             " is not where its move ended, though the program there says that it did: check that nothing "
             "else moves the robot, and its calibration";
    case Cause::halt_unconfirmed:
      return program +
             " does not say that it stopped the robot: look at the FlexPendant for a message, stop the "
             "program there, then recover here";
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  if (cause == Cause::none) return {};
  if (std::string out = service_sentence(cause, detail, where, text); !out.empty()) return out;
  if (std::string out = state_sentence(cause, where, text); !out.empty()) return out;
  if (std::string out = motion_sentence(cause, detail, where, text); !out.empty()) return out;
  return moves_sentence(cause, detail, where, text);
}

Cause cause_of_event(int code) {
  struct Row {
    int first, last;
    Cause cause;
  };
  // 10014, 10125, 41822, 41830 and 50453 are in public reports of users; the others are recalled.
  constexpr Row kRows[] = {{10012, 10012, Cause::guard_stop},     {10013, 10013, Cause::emergency_stop},
                           {10014, 10014, Cause::system_failure}, {10015, 10015, Cause::manual_mode},
                           {10010, 10010, Cause::motors_off},     {20010, 20010, Cause::emergency_stop},
                           {20202, 20223, Cause::guard_stop},     {34316, 34319, Cause::load},
                           {37001, 37001, Cause::motors_refused}, {41822, 41822, Cause::commands_late},
                           {41830, 41830, Cause::commands_late},  {50024, 50024, Cause::speed},
                           {50026, 50026, Cause::singularity},    {50027, 50028, Cause::joint_range},
                           {50050, 50050, Cause::joint_range},    {50052, 50052, Cause::speed},
                           {50056, 50056, Cause::collision},      {50057, 50057, Cause::system_failure},
                           {50204, 50204, Cause::collision},      {50376, 50376, Cause::singularity},
                           {50453, 50453, Cause::egm_error},      {90206, 90206, Cause::emergency_stop},
                           {90518, 90521, Cause::emergency_stop}};
  for (const Row& row : kRows)
    if (code >= row.first && code <= row.last) return row.cause;
  return Cause::none;
}

Cause cause_of_state(std::string_view control, std::string_view mode) {
  if (control == "emergencystop" || control == "emergencystopreset") return Cause::emergency_stop;
  if (control == "guardstop") return Cause::guard_stop;
  if (control == "sysfail") return Cause::system_failure;
  if (control == "init") return Cause::starting;
  if (mode.starts_with("MAN")) return Cause::manual_mode;
  if (control == "motoroff") return Cause::motors_off;
  return Cause::none;
}

}  // namespace polyarm::abb
