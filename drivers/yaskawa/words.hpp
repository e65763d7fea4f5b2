#pragma once
/// The causes for which a link to a controller of Yaskawa does not start or ends, in words. Const: any
/// thread.
#include <cstdint>
#include <string>

namespace polyarm::yaskawa {

/// The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,  ///< text: what to check, of the socket
  hses_silent,  ///< the High-Speed Ethernet Server does not answer
  hses_bad_data,
  hses_refused,  ///< detail: added status, or status
  moto_silent,   ///< MotoROS does not answer
  state_silent,  ///< its states ended
  bad_data,      ///< what came is no message of MotoROS
  closed,        ///< MotoROS closed a connection
  other_client,  ///< it closed a new one at once
  no_group,      ///< detail: group without feedback
  wrong_rate,    ///< detail: Hz
  alarm,         ///< detail: code; text: of HSES
  error,         ///< text: the same
  emergency_stop,
  teach_mode,
  not_remote,
  servo_off,
  servo_refused,  ///< the job starts only with servos on, and they stay off
  hold,           ///< detail: 1 pendant, 2 external, 3 command; 0: unknown
  not_started,    ///< the job INIT_ROS does not run
  waiting_ros,    ///< it runs, and does not wait for MotoROS
  skill_send,     ///< DX100
  pfl,            ///< a collaborative robot was touched
  increment_refused,
  not_ready,       ///< detail: subcode
  moves,           ///< something else moves the robot
  start_position,  ///< the first point is not where the robot stands
  speed_refused,
  point_refused,   ///< detail: subcode
  moto_failed,     ///< detail: result
  points_late,     ///< the controller ran out of points
  points_stuck,    ///< the controller takes no points
  too_long,        ///< a motion without a rest
  signal_refused,  ///< detail: address
  too_fast,        ///< the loop asks for more than the limits; detail: axis * 3 + LimitKind
  loop_silent,
  jump,  ///< detail: joint
  // of forward mode
  no_watchdog,       ///< the ladder does not hold the robot when the heartbeat stops
  job_runs,          ///< text: name of another job
  job_version,       ///< detail: of the job POLYARM
  job_stopped,       ///< the job POLYARM does not run
  tool_number,       ///< detail: that is selected; text: that is wanted
  tool_differs,      ///< detail: mm; text: where the controller has its TCP
  moves_changed,     ///< somebody else writes the variables of the job
  hold_ignored,      ///< a hold does not stop the job
  halt_unconfirmed,  ///< the moves were not forgotten in time
  off_target,        ///< detail: joint
  joint_commands,    ///< detail: joint
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 192.168.255.1"; `text`: what the
/// system or the controller said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

/// A subcode of MotoROS, NotReady or Invalid, or another result.
struct Why {
  Cause cause;
  int detail;
};
Why why_not(int result, int subcode);

}  // namespace polyarm::yaskawa
