#include "drivers/kuka/words.hpp"

#include <iterator>

#include "drivers/wire/words.hpp"

namespace polyarm::kuka {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "unreachable",
                                    "eki-busy",
                                    "eki-silent",
                                    "eki-bad-data",
                                    "eki-closed",
                                    "program-version",
                                    "old-rsi",
                                    "axes",
                                    "wrong-rate",
                                    "port-taken",
                                    "manual-mode",
                                    "emergency-stop",
                                    "guard-stop",
                                    "drives-off",
                                    "drives-refused",
                                    "message",
                                    "start-refused",
                                    "rsi-refused",
                                    "no-packets",
                                    "other-sender",
                                    "bad-data",
                                    "silent",
                                    "restarted",
                                    "late-answers",
                                    "relative-late",
                                    "correction-limit",
                                    "soft-limit",
                                    "program-stopped",
                                    "program-ended",
                                    "rsi-ended",
                                    "output-refused",
                                    "too-fast",
                                    "loop-silent",
                                    "jump",
                                    "joint-commands",
                                    "off-target",
                                    "moves-refused",
                                    "moves-ended",
                                    "halt-unconfirmed"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Cause::halt_unconfirmed) + 1);
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

std::string axis(int detail) {
  return "axis A" + std::to_string(detail + 1);
}

std::string too_fast(int detail, const std::string& where) {
  return wire::too_fast_sentence(detail, where) +
         ", or raise `max_speed`; if cycles of the "
         "loop were late, keep other load off this computer";
}

std::string start_refused(int detail, const std::string& where) {
  const std::string begin = "the program PolyarmEki of " + where + " does not start RSI: ";
  switch (detail) {
    case 2:
      return begin +
             "choose EXT with the key switch of its smartPAD, or AUT and press Start for the program "
             "PolyarmRsi";
    case 3:
      return begin +
             "drives, safety or a message do not allow motion; look at its smartPAD, acknowledge what is "
             "there, then recover here";
    case 4:
      return begin + "another program is selected; deselect it at its smartPAD";
    default:
      return begin + "it does not know the request; copy the files of `polyarm setup kuka --write` anew";
  }
}

/// Connections and EthernetKRL.
std::string service_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::unreachable:
      return where + ": " + text +
             "; the submit interpreter must run PolyarmEki (`polyarm setup kuka` writes it)";
    case Cause::eki_busy:
      return where +
             " closed the connection of EthernetKRL at once: its program takes one client; end the other "
             "program that uses it";
    case Cause::eki_silent:
      return where +
             " does not answer over EthernetKRL: check cable and power; at its smartPAD the submit "
             "interpreter must be green (Select/Start), with PolyarmEki in it";
    case Cause::eki_bad_data:
      return where +
             " sent what is no message of PolyarmEki: check `eki_port`; another program may listen there";
    case Cause::eki_closed:
      return where +
             " closed the connection of EthernetKRL: it was switched off or restarted, or its submit "
             "interpreter was stopped; start that again, then recover here";
    case Cause::program_version:
      return where + " has version " + std::to_string(detail) +
             " of PolyarmEki, and this driver needs another one: copy the files of `polyarm setup kuka "
             "--write` anew";
    case Cause::old_rsi:
      return where + " has RSI " + std::to_string(detail) +
             "; this driver needs RSI 3, 4 or 5 (KR C4, KR C5): have the option updated";
    case Cause::axes:
      return where + " has " + std::to_string(detail) +
             " axes; this driver takes robots with six, without external axes";
    case Cause::wrong_rate:
      return where + " runs RSI at " + std::to_string(detail) +
             " Hz, and the cell at another rate: write `rate: " + std::to_string(detail) +
             "` into the cell, or set `pace: false`";
    case Cause::port_taken:
      return "the port for RSI of " + where + " cannot be opened: " + text +
             "; end the program that uses it, or change `rsi_port` here and PORT in the file PolyarmRsi.xml";
    case Cause::output_refused:
      return where + " does not switch output " + std::to_string(detail) +
             ": check its number, and that no other program or field bus owns it";
    default:
      return {};
  }
}

/// What a person sees at the smartPAD.
std::string state_sentence(Cause cause, int detail, const std::string& where) {
  switch (cause) {
    case Cause::manual_mode:
      return where + " is in mode T" + std::to_string(detail) +
             ": choose EXT with the key switch of its smartPAD, then recover here";
    case Cause::emergency_stop:
      return where +
             " is in an emergency stop: look why, release the button, acknowledge the message at its "
             "smartPAD, then recover here";
    case Cause::guard_stop:
      return "a guard of " + where +
             " is open (operator safety): close it, acknowledge it where its safety asks for that, then "
             "recover here";
    case Cause::drives_off:
      return "the drives of " + where + " are off: switch them on at its smartPAD (I), then recover here";
    case Cause::drives_refused:
      return "the drives of " + where +
             " do not switch on: look at its smartPAD for the message, check enabling switch and safety";
    case Cause::message:
      return where +
             " stopped with a message, such as a collision, a torque, a workspace or a limit of RSI: read "
             "it at its smartPAD, remove its cause, acknowledge it, then recover here";
    case Cause::program_stopped:
      return "the program of " + where + " was stopped there: look why, then recover here to start it again";
    case Cause::program_ended:
      return "the program of " + where +
             " ended or was deselected there: recover here to start it again (in AUT: select PolyarmRsi and "
             "press Start)";
    default:
      return {};
  }
}

/// RSI, the loop and its commands.
std::string motion_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::rsi_refused:
      return "RSI of " + where + " does not begin: its function returned " + std::to_string(detail) +
             "; check that PolyarmRsi.rsi.xml (RSI 3) or PolyarmRsi.rsix and PolyarmRsi.xml are in its "
             "folder SensorInterface, and that RSI is installed";
    case Cause::no_packets:
      return where + " started its program, but no packets of RSI arrive at " + text +
             ": check IP_NUMBER and PORT in PolyarmRsi.xml, the address of its RSI network, and that no "
             "firewall blocks UDP";
    case Cause::other_sender:
      return "packets of RSI come from " + text + ", and not from " + where + ": write `rsi_host: " + text +
             "` if that is its RSI network, else give each controller its "
             "own `rsi_port`";
    case Cause::bad_data:
      return where +
             " sent what is no datagram of RSI: check that PolyarmRsi.xml sends DEF_AIPos, and that nothing "
             "else sends to `rsi_port`";
    case Cause::silent:
      return where +
             " sends no packets of RSI any more: check cable and power, and that no firewall blocks UDP; "
             "its program may have ended";
    case Cause::restarted:
      return "the clock (IPOC) of RSI of " + where +
             " went back while the robot moved: its program was started again there; recover here";
    case Cause::late_answers:
      return where + " got " + std::to_string(detail) +
             " answers in a row too late, and RSI ended at its limit (Timeout of its ETHERNET object): use a "
             "cable, give the loop priority (`priority`), and keep other load off this computer";
    case Cause::relative_late:
      return where +
             " missed an answer, and with relative corrections the robot would end elsewhere: use absolute "
             "corrections, or mend the network";
    case Cause::correction_limit:
      return axis(detail) + " of " + where +
             " was commanded further from where RSI began than its context allows: recover here, which "
             "begins anew, or raise the limits with `polyarm setup kuka --limit`";
    case Cause::soft_limit:
      return axis(detail) + " of " + where +
             " was commanded beyond its software limit: make the limits in the cell those of the "
             "controller";
    case Cause::rsi_ended:
      return "RSI of " + where +
             " ended though its program runs: somebody called RSI_OFF or the Stop of its context; recover "
             "here to start it again";
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

/// Forward mode.
std::string moves_sentence(Cause cause, int detail, const std::string& where) {
  switch (cause) {
    case Cause::joint_commands:
      return wire::joint_commands_sentence(detail, where);
    case Cause::off_target:
      return axis(detail) + " of " + where +
             " is not where its move ended, though the program there says that it did: check that nothing "
             "else moves the robot, and its mastering";
    case Cause::moves_refused:
      return "the program PolyarmMoves of " + where + " takes no move (" + std::to_string(detail) +
             "): its buffer is full or its session is over; recover here, which begins a new one";
    case Cause::moves_ended:
      return "the program PolyarmMoves of " + where +
             " ended the session of moves by itself: no request reached it within `watchdog_ms`, or another "
             "program uses its EthernetKRL; check the network, then recover here";
    case Cause::halt_unconfirmed:
      return "the program PolyarmMoves of " + where +
             " does not say that it stopped the robot: look at its smartPAD for a message, cancel the "
             "program, then recover here";
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  if (cause == Cause::none) return {};
  if (cause == Cause::start_refused) return start_refused(detail, where);
  if (std::string out = service_sentence(cause, detail, where, text); !out.empty()) return out;
  if (std::string out = state_sentence(cause, detail, where); !out.empty()) return out;
  if (std::string out = moves_sentence(cause, detail, where); !out.empty()) return out;
  return motion_sentence(cause, detail, where, text);
}

}  // namespace polyarm::kuka
