#pragma once
/// The controller's own numbers in words, and the causes for which a link ends. Const: any thread.
#include <cstdint>
#include <string>

namespace polyarm::ur {

/// Of the controller, as RTDE reports them.
enum RobotMode : int {
  no_controller = -1,
  disconnected,
  confirm_safety,
  booting,
  power_off,
  power_on,
  idle,
  backdrive,
  running,
  updating
};
enum SafetyMode : int {
  safety_normal = 1,
  safety_reduced,
  protective_stop,
  recovery,
  safeguard_stop,
  system_emergency,
  robot_emergency,
  violation,
  fault
};
enum RuntimeState : int { stopping = 0, stopped, playing, pausing, paused, resuming };

/// As the dashboard writes them: "RUNNING", "PROTECTIVE_STOP".
const char* robot_mode_name(int mode);
const char* safety_mode_name(int mode);

/// Why a link does not start or ends. The numbers are stable: tests and reports use them.
enum class Cause : std::uint8_t {
  none,
  unreachable,    ///< the text of the socket says more
  wrong_version,  ///< RTDE refuses both protocol versions
  too_old,        ///< the controller's software
  missing_value,  ///< RTDE does not know a value that is needed
  second_client,  ///< another program holds the RTDE inputs
  not_remote,     ///< local control
  robot_mode,     ///< detail: RobotMode
  protective_stop,
  safeguard_stop,
  emergency_stop,
  safety_fault,     ///< detail: SafetyMode
  program_stopped,  ///< by hand
  program_paused,   ///< by hand
  script_error,     ///< the text of the controller says more
  no_answer_back,   ///< the robot's program did not connect to this computer
  reverse_closed,   ///< the robot's program closed its connection
  commands_late,    ///< the robot's program got no command in time
  loop_silent,      ///< the control loop gave no command in time
  jump,             ///< detail: joint
  rtde_silent,
  rtde_closed,
  bad_data,
  not_reading,     ///< the robot's program does not read its commands
  other_program,   ///< another program runs on the controller; detail: RuntimeState
  wrong_rate,      ///< detail: Hz of the controller
  off_target,      ///< forward: a move ended elsewhere; detail: joint
  joint_commands,  ///< forward: a controller here commanded a joint; detail: joint
};
const char* name(Cause cause);

/// One sentence: what happened, and what to do. `where`: "the controller at 192.168.1.10"; `text`: what the
/// controller or the system said, may be empty.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

/// The cause that a robot mode and a safety mode are for a robot that should move; none: it may.
struct Obstacle {
  Cause cause = Cause::none;
  int detail = 0;
};
Obstacle obstacle_of(int robot_mode, int safety_mode) noexcept;

}  // namespace polyarm::ur
