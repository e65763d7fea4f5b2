#pragma once
/// The causes for which a link to a controller of UFACTORY does not start or ends, in words. Const: any
/// thread.
#include <cstdint>
#include <string>

namespace polyarm::xarm {

/// The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,     ///< text: what to check, of the socket
  command_silent,  ///< a request gets no answer
  report_silent,   ///< reports ended
  bad_data,        ///< what came is no frame of this wire
  closed,          ///< the controller closed a connection
  wrong_axes,      ///< detail: axes of the controller's arm
  old_firmware,    ///< text: the firmware
  wrong_rate,      ///< detail: Hz
  emergency_stop,  ///< detail of this and those below: error code
  joint_error,
  collision,
  self_collision,
  joint_limit,
  kinematics,
  speed_limit,
  planning,
  boundary,
  tool_error,
  force_sensor,
  controller_error,
  error_pending,   ///< activating may not clear it; detail: code
  enable_refused,  ///< the motors do not switch on
  mode_refused,    ///< detail: the mode that is not taken
  state_refused,   ///< it does not become ready
  mode_changed,    ///< detail: the new mode
  paused,
  stopped,  ///< without an error; detail: state
  not_ready,
  command_refused,  ///< a servo command was invalid
  request_refused,  ///< detail: register
  signal_refused,   ///< detail: number of the signal
  moves,            ///< something else moves the robot
  too_fast,         ///< the loop asks for more than the limits; detail: axis * 3 + LimitKind
  loop_silent,
  jump,              ///< detail: joint
  joint_commands,    ///< forward mode, and a controller commands joints; detail: joint
  moves_refused,     ///< detail: warning code, or 0
  off_target,        ///< detail: joint
  tool_differs,      ///< detail: mm between the TCP here and there; text: in which directions
  halt_unconfirmed,  ///< it does not say that it stopped the robot and forgot its moves
  watchdog,          ///< of forward mode; detail: watchdog::Health; text: its ms without a heartbeat
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 192.168.1.200"; `text`: what the
/// system or the controller said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

/// The cause that an error code of the controller is.
Cause cause_of_error(int code);
/// What an error code means and what to do, such as "the robot touched something: clear the space".
std::string error_words(int code);
/// The same for a warning code.
std::string warning_words(int code);
/// "servo", "joint teach", …
const char* mode_words(int mode);

}  // namespace polyarm::xarm
