#pragma once
/// The causes for which a link to a KUKA controller does not start or ends, in words. Const: any thread.
#include <cstdint>
#include <string>

namespace polyarm::kuka {

/// The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,   ///< text: what to check, of the socket
  eki_busy,      ///< our program takes one client, and has one
  eki_silent,    ///< our program does not answer
  eki_bad_data,  ///< what came is no message of our program
  eki_closed,
  program_version,  ///< detail: version of the KRL program there
  old_rsi,          ///< detail: version of RSI
  axes,             ///< detail: axes that the controller has
  wrong_rate,       ///< detail: Hz of the controller
  port_taken,       ///< text: the system's
  manual_mode,      ///< detail: 1 T1, 2 T2
  emergency_stop,
  guard_stop,
  drives_off,
  drives_refused,
  message,           ///< a message stops the robot
  start_refused,     ///< detail: EkiResult
  rsi_refused,       ///< detail: what an RSI function returned
  no_packets,        ///< text: own address
  other_sender,      ///< text: its address
  bad_data,          ///< what came is no datagram of RSI
  silent,            ///< RSI runs, and its packets do not arrive
  restarted,         ///< the IPOC went back
  late_answers,      ///< detail: answers that were late, in a row
  relative_late,     ///< one answer was late, with relative corrections
  correction_limit,  ///< detail: axis
  soft_limit,        ///< detail: axis
  program_stopped,
  program_ended,   ///< deselected, reset or at its end
  rsi_ended,       ///< RSI ended, the program runs
  output_refused,  ///< detail: number of the output
  too_fast,        ///< the loop asks for more than the limits; detail: axis * 3 + LimitKind
  loop_silent,
  jump,              ///< detail: joint
  joint_commands,    ///< forward mode, and a controller commands joints; detail: joint
  off_target,        ///< detail: axis
  moves_refused,     ///< detail: EkiResult
  moves_ended,       ///< the session of moves ended at the controller
  halt_unconfirmed,  ///< the program does not say that it stopped the robot
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 172.31.1.147"; `text`: what the
/// system said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

}  // namespace polyarm::kuka
