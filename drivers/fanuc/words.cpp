#include "drivers/fanuc/words.hpp"

#include <string_view>

#include "drivers/fanuc/rmi.hpp"
#include "drivers/wire/words.hpp"

namespace polyarm::fanuc {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {
      "none",       "unreachable",   "rmi-refused",    "rmi-busy",        "rmi-silent",    "rmi-closed",
      "terminated", "stream-silent", "wrong-version",  "bad-data",        "no-limits",     "io-refused",
      "wrong-rate", "teach-mode",    "emergency-stop", "fence",           "deadman",       "contact",
      "servo-off",  "alarm",         "not-ready",      "program-stopped", "commands-late", "limit",
      "too-fast",   "loop-silent",   "jump",           "move-refused",    "off-target",    "joint-commands"};
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

std::string quoted(const std::string& text) {
  return text.empty() ? "" : " (it says: " + text + ")";
}

std::string refused(int error, const std::string& where, const std::string& text) {
  std::string out =
      where + " refuses " + text + ": " + rmi_error(error) + " (error " + std::to_string(error) + ")";
  if (error == kRmiServoOff || error == kRmiBadState || error == kRmiCannotRun)
    return out +
           "; clear its alarms, disable the teach pendant, choose AUTO and abort all programs, then "
           "activate again";
  if (error == kRmiBadCommand || error == kRmiProgram)
    return out +
           "; check that the options J519 (Stream Motion) and R912 (Remote Motion) are installed, both are "
           "in S636";
  return out + "; abort all programs at its teach pendant, then activate again";
}

std::string move_refused(int error, const std::string& where, const std::string& text) {
  return where + " refuses a move (" + text + "): " + rmi_error(error) + " (error " + std::to_string(error) +
         "); check the point, the tool and the limits of the joints at the controller, then recover here";
}

std::string too_fast(int detail, const std::string& where) {
  constexpr const char* kKinds[] = {"velocity", "acceleration", "jerk"};
  return "joint " + std::to_string(detail / 3 + 1) + " was commanded beyond the " + kKinds[detail % 3] +
         " limit of " + where +
         " for longer than it can be made up for; the robot was stopped: lower the limits of the robot in "
         "the "
         "cell to those of the controller";
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::none:
      return {};
    case Cause::unreachable:
      return where + ": " + text;
    case Cause::rmi_refused:
      return refused(detail, where, text);
    case Cause::rmi_busy:
      return "another program uses the Remote Motion Interface of " + where +
             ": end it; after a program that hung, the controller frees the interface only after its "
             "$RMI_CFG.$DISCNT_TIM";
    case Cause::rmi_silent:
      return where + " does not answer " + text +
             " over the Remote Motion Interface: check that $RMI_CFG.$ASBN_ENB is FALSE, and switch the "
             "controller off and on";
    case Cause::rmi_closed:
      return where +
             " closed the Remote Motion Interface: it restarts, was switched off, or somebody aborted all "
             "its "
             "programs; recover here when it is ready";
    case Cause::terminated:
      return where +
             " ended the remote session (idle for too long, or a fault); recover here to open a new one";
    case Cause::stream_silent:
      return where +
             " sends no packets of Stream Motion: check cable and power, that no firewall blocks UDP, and "
             "that "
             "the option J519 is installed; if the rest of it answers, switch the controller off and on";
    case Cause::wrong_version:
      return where + " speaks version " + std::to_string(detail) +
             " of Stream Motion; this driver speaks 3 and 4: it needs an R-30iB Plus or newer with software "
             "V9.40P or newer";
    case Cause::bad_data:
      return where +
             " sent what is no packet of its protocols: check that the port is 60015 and that nothing in "
             "between changes the packets" +
             quoted(text);
    case Cause::no_limits:
      return where + " does not tell the limits of axis " + std::to_string(detail) +
             ": is this a robot with six axes in motion group 1?";
    case Cause::io_refused:
      return where + " refuses the inputs and outputs of the cell (error " + std::to_string(detail) +
             "): check that `digital_in` and `digital_out` are ranges that are assigned at the controller";
    case Cause::wrong_rate:
      return where + " runs at " + std::to_string(detail) +
             " Hz, and the cell at another rate: write `rate: " + std::to_string(detail) +
             "` into the cell, or set `pace: false`";
    case Cause::teach_mode:
      return "the teach pendant of " + where +
             " is enabled (T1 or T2): disable it, choose AUTO and reset, then recover here" + quoted(text);
    case Cause::emergency_stop:
      return where +
             " is in an emergency stop: make sure that nobody is in danger, release the button, then recover "
             "here" +
             quoted(text);
    case Cause::fence:
      return "the fence of " + where + " is open: clear the guarded area and close it, then recover here" +
             quoted(text);
    case Cause::deadman:
      return "the enabling switch at the teach pendant of " + where +
             " was released; disable the pendant and choose AUTO, then recover here" + quoted(text);
    case Cause::contact:
      return where + " stopped at a contact: look what the arm touched, free it, then recover here" +
             quoted(text);
    case Cause::servo_off:
      return "the servos of " + where + " are off" + quoted(text) +
             ": clear the alarm at its teach pendant, then activate again";
    case Cause::alarm:
      return where + " stopped with an alarm" + quoted(text) +
             ": look it up in the maker's manual, remove its cause, then recover here";
    case Cause::not_ready:
      return where + " does not become ready for streamed motion" + quoted(text) +
             ": choose AUTO, disable the teach pendant, abort all programs, and check that "
             "$RMI_CFG.$ASBN_ENB is "
             "FALSE";
    case Cause::program_stopped:
      return "remote motion on " + where +
             " was ended there without an alarm: its program was aborted or held by hand, or it dropped "
             "commands; recover here to start it again";
    case Cause::commands_late:
      return where +
             " got no command in time: use a cable, give the loop priority (`priority`), and keep other load "
             "off this computer" +
             quoted(text);
    case Cause::limit:
      return where + " refused the motion" + quoted(text) +
             ": lower the robot's speed, acceleration and jerk in the cell, then recover here";
    case Cause::too_fast:
      return too_fast(detail, where);
    case Cause::loop_silent:
      return wire::loop_silent_sentence(where);
    case Cause::jump:
      return wire::jump_sentence(detail, where);
    case Cause::move_refused:
      return move_refused(detail, where, text);
    case Cause::off_target:
      return where + " reports the end of a move, but joint " + std::to_string(detail + 1) +
             " is elsewhere: compare the angles here and at its teach pendant (joint 3 too), then recover "
             "here";
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
  }
  return {};
}

Cause cause_of_alarm(std::string_view text) {
  struct Row {
    const char* code;
    Cause cause;
  };
  // Codes of the maker's alarm list; MOTN-603 is named in airo-ugent/airo-fanuc, the others are recalled.
  constexpr Row kRows[] = {{"SRVO-001", Cause::emergency_stop},
                           {"SRVO-002", Cause::emergency_stop},
                           {"SRVO-007", Cause::emergency_stop},
                           {"SRVO-289", Cause::emergency_stop},
                           {"SRVO-004", Cause::fence},
                           {"SRVO-003", Cause::deadman},
                           {"SRVO-050", Cause::contact},
                           {"Contact stop", Cause::contact},
                           {"MOTN-603", Cause::commands_late},
                           {"MOTN-607", Cause::alarm},
                           {"MOTN-6", Cause::limit},
                           {"MOTN-", Cause::limit}};
  if (text.empty() || text.starts_with("No Error")) return Cause::none;
  for (const Row& row : kRows)
    if (text.find(row.code) != std::string_view::npos) return row.cause;
  return Cause::alarm;
}

}  // namespace polyarm::fanuc
