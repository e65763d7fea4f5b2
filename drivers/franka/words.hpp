#pragma once
/// The causes for which a link to a robot of Franka does not start or ends, in words. Const: any thread.
#include <cstdint>
#include <string>

namespace polyarm::franka {

/// The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,     ///< text: what to check, of the socket
  no_session,      ///< the connection was closed at once: FCI is off, or another client has the robot
  command_silent,  ///< a request gets no answer
  silent,          ///< states ended, or never came; text: where they were awaited
  bad_data,        ///< what came is not of this wire
  closed,          ///< the robot closed the connection
  other_version,   ///< detail: version of the robot
  other_sender,    ///< states come from another address; text: it
  wrong_rate,      ///< detail: Hz
  user_stop,
  guiding,    ///< somebody guides the robot by hand
  locked,     ///< the brakes are closed, or the robot is in no mode for motion
  safety,     ///< a safety function of the robot ended or refuses a motion
  collision,  ///< detail of this and those below: number of the error flag; text: all names
  self_collision,
  joint_limit,
  speed_limit,
  discontinuity,
  start_pose,
  deviation,
  communication,
  controller_error,
  reflex_pending,    ///< activating may not recover; detail: error flag; text: all names
  recovery_refused,  ///< detail: Status
  motion_refused,    ///< detail: Status
  motion_ended,      ///< without an error; detail: Status
  setting_refused,   ///< detail: Request * 16 + Status
  low_success,       ///< detail: percent
  position_limit,    ///< the next command would leave the range; detail: joint
  hand_unreachable,  ///< text
  hand_silent,
  hand_failed,   ///< text: what
  hand_version,  ///< detail
  too_fast,      ///< detail: joint * 3 + LimitKind
  loop_silent,
  jump,  ///< detail: joint
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 172.16.0.2"; `text`: what the
/// system or the controller said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

}  // namespace polyarm::franka
