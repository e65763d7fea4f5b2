#include "drivers/franka/errors.hpp"

#include <algorithm>
#include <iterator>

namespace polyarm::franka {

namespace {

constexpr ErrorFacts kFacts[kErrors] = {
    {"joint_position_limits_violation",
     "a joint is at the end of its range: guide it back by hand, and change the path", Cause::joint_limit},
    {"cartesian_position_limits_violation",
     "the robot left a space that a safety rule of Desk allows: guide it back by hand, and change the path "
     "or the rule",
     Cause::joint_limit},
    {"self_collision_avoidance_violation",
     "the arm came close to itself: guide it apart by hand, and change the path", Cause::self_collision},
    {"joint_velocity_violation", "a joint was too fast: lower the speed", Cause::speed_limit},
    {"cartesian_velocity_violation", "the end effector or the elbow was too fast: lower the speed",
     Cause::speed_limit},
    {"force_control_safety_violation",
     "a force went beyond its safe value: check mass and centre of tool and load", Cause::collision},
    {"joint_reflex",
     "a joint felt more torque than `collision_torque` allows: clear the space; check tool and load if "
     "nothing touched the robot",
     Cause::collision},
    {"cartesian_reflex",
     "the end effector felt more force than `collision_force` allows: clear the space; check tool and load "
     "if nothing touched the robot",
     Cause::collision},
    {"max_goal_pose_deviation_violation",
     "the end of the motion was too far from its goal: check tool and load, and that nothing holds the robot",
     Cause::deviation},
    {"max_path_pose_deviation_violation",
     "the robot strayed too far from the commanded path: check tool and load, and that nothing holds the "
     "robot",
     Cause::deviation},
    {"cartesian_velocity_profile_safety_violation",
     "the speed of the end effector is not safe: lower the speed", Cause::speed_limit},
    {"joint_position_motion_generator_start_pose_invalid",
     "the first command was away from where the robot stood: recover, and look whether another program "
     "commands it too",
     Cause::start_pose},
    {"joint_motion_generator_position_limits_violation",
     "a commanded joint position is outside of its range: change the path", Cause::joint_limit},
    {"joint_motion_generator_velocity_limits_violation",
     "a commanded joint speed is beyond its limit, which is lower near the ends of the range: lower the "
     "speed there",
     Cause::speed_limit},
    {"joint_motion_generator_velocity_discontinuity",
     "the commanded joint speed changed too quickly: lower the accelerations of the robot in the cell",
     Cause::discontinuity},
    {"joint_motion_generator_acceleration_discontinuity",
     "the commanded joint acceleration changed too quickly: lower the jerks of the robot in the cell",
     Cause::discontinuity},
    {"cartesian_position_motion_generator_start_pose_invalid",
     "the first Cartesian command was away from where the robot stood: look which other program commands it",
     Cause::start_pose},
    {"cartesian_motion_generator_elbow_limit_violation",
     "the elbow is at the end of its range: use joint commands", Cause::joint_limit},
    {"cartesian_motion_generator_velocity_limits_violation",
     "a commanded Cartesian speed is beyond its limit: lower the speed of that program", Cause::speed_limit},
    {"cartesian_motion_generator_velocity_discontinuity",
     "the commanded Cartesian speed changed too quickly: lower the accelerations of that program",
     Cause::discontinuity},
    {"cartesian_motion_generator_acceleration_discontinuity",
     "the commanded Cartesian acceleration changed too quickly: lower the jerks of that program",
     Cause::discontinuity},
    {"cartesian_motion_generator_elbow_sign_inconsistent",
     "the elbow of a Cartesian command has the other sign: use joint commands", Cause::start_pose},
    {"cartesian_motion_generator_start_elbow_invalid",
     "the first elbow of a Cartesian command is away from that of the robot: use joint commands",
     Cause::start_pose},
    {"force_controller_desired_force_tolerance_violation",
     "a desired force was not reached: check the contact, and tool and load", Cause::deviation},
    {"start_elbow_sign_inconsistent",
     "the elbow of the first Cartesian command has the other sign: use joint commands", Cause::start_pose},
    {"communication_constraints_violation",
     "too many commands came late or not at all: use a cable without a switch, a real-time kernel, and fewer "
     "programs on this computer",
     Cause::communication},
    {"power_limit_violation", "the motors would have needed too much power: lower accelerations or load",
     Cause::controller_error},
    {"cartesian_motion_generator_joint_position_limits_violation",
     "a Cartesian command led a joint out of its range: change that path", Cause::joint_limit},
    {"cartesian_motion_generator_joint_velocity_limits_violation",
     "a Cartesian command made a joint too fast, as near a singular pose: change that path",
     Cause::speed_limit},
    {"cartesian_motion_generator_joint_velocity_discontinuity",
     "a Cartesian command changed the speed of a joint too quickly: change that path", Cause::discontinuity},
    {"cartesian_motion_generator_joint_acceleration_discontinuity",
     "a Cartesian command changed the acceleration of a joint too quickly: change that path",
     Cause::discontinuity},
    {"cartesian_position_motion_generator_invalid_frame_flag",
     "a Cartesian command is no pose: look which other program commands the robot", Cause::controller_error},
    {"controller_torque_discontinuity",
     "a commanded torque changed too quickly: look which other program commands the robot",
     Cause::discontinuity},
    {"joint_p2p_insufficient_torque_for_planning",
     "the robot has too little torque for a motion of its own: guide it elsewhere by hand, and check the "
     "load",
     Cause::controller_error},
    {"tau_J_range_violation",
     "a torque sensor is out of its range: take the load off, restart the robot, call Franka if it stays so",
     Cause::controller_error},
    {"instability_detected", "the robot began to swing: lower `joint_stiffness`, check tool and load",
     Cause::controller_error},
    {"joint_move_in_wrong_direction", "a joint outside of its range moved farther out: guide it back by hand",
     Cause::joint_limit},
    {"cartesian_spline_motion_generator_violation", "a motion of Desk went beyond a limit: change it in Desk",
     Cause::controller_error},
    {"joint_via_motion_generator_planning_joint_limit_violation",
     "a motion of Desk would leave the range of a joint: change it in Desk", Cause::joint_limit},
    {"base_acceleration_initialization_timeout",
     "the sensor for the direction of gravity does not start: restart the robot", Cause::controller_error},
    {"base_acceleration_invalid_reading",
     "the sensor for the direction of gravity gives no numbers: restart the robot, check that it stands "
     "upright",
     Cause::controller_error},
};
constexpr ErrorFacts kUnknown = {"unknown_error", "libfranka does not name this error: look into Desk",
                                 Cause::controller_error};
static_assert(std::size(kFacts) == kErrors);

}  // namespace

const ErrorFacts& error_facts(int index) {
  const bool known = index >= 0 && index < static_cast<int>(kErrors);
  return known ? kFacts[index] : kUnknown;
}

/// What touched the robot, and what the network did, explain what the others only show.
int first_error(const ErrorFlags& flags) noexcept {
  for (const ErrorFlag telling :
       {ErrorFlag::joint_reflex, ErrorFlag::cartesian_reflex, ErrorFlag::communication})
    if (flags[static_cast<std::size_t>(telling)]) return static_cast<int>(telling);
  for (std::size_t i = 0; i < kErrors; ++i)
    if (flags[i]) return static_cast<int>(i);
  return -1;
}

std::string error_names(const ErrorFlags& flags) {
  std::string out;
  for (std::size_t i = 0; i < kErrors; ++i)
    if (flags[i]) out += (out.empty() ? "" : ", ") + std::string(kFacts[i].name);
  return out;
}

}  // namespace polyarm::franka
