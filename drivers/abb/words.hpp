#pragma once
/// The causes for which a link to an ABB controller ends, in words. Const: any thread.
#include <cstdint>
#include <string>
#include <string_view>

namespace polyarm::abb {

/// Why a link does not start or ends. The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,     ///< text: what to check, of the socket
  tls,             ///< no TLS at this port; text: the library's
  certificate,     ///< another certificate than the one in `fingerprint`; text: that one
  login,           ///< user or password are wrong
  forbidden,       ///< the user may not do that; text: what
  busy,            ///< too many sessions or requests
  rws_silent,      ///< text: what was asked
  rws_bad_data,    ///< text: what was asked
  rws_refused,     ///< detail: HTTP status; text: what was asked
  other_version,   ///< Robot Web Services of the other version
  old_software,    ///< text: RobotWare
  no_option,       ///< Externally Guided Motion is not installed
  no_module,       ///< our RAPID module is not loaded; text: task
  no_signal,       ///< text: name
  signal_refused,  ///< text: name
  manual_mode,     ///< text: mode
  emergency_stop,
  guard_stop,
  motors_off,
  motors_refused,  ///< text: the controller's
  system_failure,
  starting,         ///< the controller is not ready yet
  mastership,       ///< somebody else holds it
  start_refused,    ///< text: the controller's
  no_packets,       ///< the program runs, and EGM sends nothing
  not_running,      ///< EGM does not begin to follow
  bad_data,         ///< what came is no EGM
  old_egm,          ///< EGM before version 1.1, whose units differ
  axes,             ///< detail: joints that the controller has
  silent,           ///< packets of EGM ended
  restarted,        ///< EGM began anew
  other_sender,     ///< packets of another controller
  program_stopped,  ///< the program was stopped there
  egm_stopped,      ///< EGM ended, the program runs
  egm_error,
  commands_late,  ///< the controller got no command in time
  joint_range,
  collision,
  singularity,
  speed,     ///< a joint was too fast for the controller
  load,      ///< motors overloaded
  event,     ///< detail: number of an entry of its event log; text: title
  too_fast,  ///< the loop asks for more than the limits; detail: axis * 3 + LimitKind
  loop_silent,
  jump,               ///< detail: joint
  wrong_rate,         ///< detail: Hz of the controller
  port_taken,         ///< text: the system's
  no_moves_module,    ///< our RAPID module of forward mode is not loaded; text: task
  moves_unreachable,  ///< the port of that program; text: what to check, of the socket
  moves_version,      ///< detail: the program's
  moves_silent,       ///< it runs, and does not answer
  moves_closed,       ///< its connection ended
  moves_bad_data,
  moves_refused,   ///< detail: MoveResult
  moves_ended,     ///< the program ended the session by itself
  move_failed,     ///< detail: number of the error
  frame_differs,   ///< text: by how much
  joint_commands,  ///< detail: joint
  arc_too_long,    ///< detail: its angle, degrees
  off_target,      ///< detail: joint
  halt_unconfirmed,
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 192.168.125.1"; `text`: what the
/// controller or the system said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

/// The cause of an entry of the event log; none for one that does not stop a robot.
Cause cause_of_event(int code);

/// The cause of the states of the panel ("motoroff", "AUTO", …); none for motors on in automatic.
Cause cause_of_state(std::string_view control, std::string_view mode);

}  // namespace polyarm::abb
