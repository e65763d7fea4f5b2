#pragma once
/// The causes for which a link to a FANUC controller ends, in words. Const: any thread.
#include <cstdint>
#include <string>
#include <string_view>

namespace polyarm::fanuc {

/// Why a link does not start or ends. The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,    ///< the text of the socket says more
  rmi_refused,    ///< detail: error number of the Remote Motion Interface; text: what was asked
  rmi_busy,       ///< another program is connected
  rmi_silent,     ///< no answer; text: what was asked
  rmi_closed,     ///< the controller closed the connection
  terminated,     ///< the controller ended the session
  stream_silent,  ///< no packet of Stream Motion
  wrong_version,  ///< of Stream Motion; detail: the controller's
  bad_data,
  no_limits,   ///< the limit tables did not come; detail: axis
  io_refused,  ///< detail: the controller's number
  wrong_rate,  ///< detail: Hz of the controller
  teach_mode,  ///< the teach pendant is enabled: T1 or T2
  emergency_stop,
  fence,    ///< the fence is open
  deadman,  ///< the enabling switch was released
  contact,  ///< a collaborative robot stopped at a contact; detail: ContactStop
  servo_off,
  alarm,            ///< text: the controller's
  not_ready,        ///< STREAM_MOTN does not take commands
  program_stopped,  ///< the controller ended the motion without an alarm
  commands_late,    ///< the controller got no command in time
  limit,            ///< the controller's own: text: its alarm
  too_fast,         ///< the loop asks for more than the limit tables; detail: axis * 3 + LimitKind
  loop_silent,      ///< the control loop gave no command in time
  jump,             ///< detail: joint
  move_refused,     ///< detail: error number of the Remote Motion Interface; text: the instruction
  off_target,       ///< a move ended elsewhere; detail: joint
  joint_commands,   ///< in forward mode a controller here commanded a joint; detail: joint
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 192.168.1.10"; `text`: what the
/// controller or the system said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

/// The cause that an alarm such as "SRVO-004 Fence open" stands for; none for "No Error" and for no text.
Cause cause_of_alarm(std::string_view text);

}  // namespace polyarm::fanuc
