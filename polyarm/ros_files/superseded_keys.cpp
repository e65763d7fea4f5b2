#include "polyarm/ros_files/superseded_keys.hpp"

namespace polyarm::ros_files {

namespace {
constexpr const char* kDrive = "diff_drive_controller/DiffDriveController";
constexpr const char* kTrajectory = "*/JointTrajectoryController";
constexpr const char* kStates = "joint_state_*/JointState*";
constexpr const char* kSteering = "*_steering_controller/*SteeringController";
constexpr const char* kManager = "controller_manager";

constexpr Superseded kRows[] = {
    {kDrive, "publish_rate",
     "odometry is published every update; leave the line out, or set the controller's update_rate"},
    {kDrive, "use_stamped_vel", "Twist and TwistStamped are both understood; leave the line out"},
    {kDrive, "*has_velocity_limits",
     "a velocity limit applies if its number is given; remove this line, and for no limit also max_velocity "
     "and min_velocity"},
    {kDrive, "*has_acceleration_limits",
     "an acceleration limit applies if its number is given; remove this line, and for no limit also "
     "max_acceleration and max_deceleration"},
    {kDrive, "*has_jerk_limits",
     "a jerk limit applies if its number is given; remove this line, and for no limit also max_jerk and "
     "min_jerk"},
    {kDrive, "*.min_acceleration",
     "write max_deceleration (zero or negative), and max_acceleration_reverse where driving backwards "
     "differs"},
    {kDrive, "wheels_per_side", "the wheels are counted from left_wheel_names; leave the line out"},
    {kDrive, "left_wheel", "write left_wheel_names: [NAME, …]"},
    {kDrive, "right_wheel", "write right_wheel_names: [NAME, …]"},
    {kDrive, "publish_cmd", "write publish_limited_velocity"},
    {kDrive, "publish_wheel_joint_controller_state",
     "joint states come from joint_state_broadcaster; leave the line out"},
    {kDrive, "allow_multiple_cmd_vel_publishers",
     "the last command counts whoever sends it; leave the line out"},
    {kDrive, "estimate_velocity_from_position", "write position_feedback: true"},
    {"tricycle_controller/*", "publish_rate", "odometry is published every update; leave the line out"},
    {"tricycle_controller/*", "use_stamped_vel",
     "Twist and TwistStamped are both understood; leave the line out"},
    {kTrajectory, "state_publish_rate", "the state is published every update; leave the line out"},
    {kTrajectory, "open_loop_control",
     "write interpolate_from_desired_state: true, and "
     "set_last_command_interface_value_as_state_on_activation "
     "where it shall start from the last command"},
    {kTrajectory, "start_with_holding", "it always holds its place when it starts; leave the line out"},
    {kTrajectory, "hold_trajectory_duration",
     "write constraints.decelerate_on_cancel: true and constraints.JOINT.max_deceleration_on_cancel"},
    {kTrajectory, "stop_trajectory_duration",
     "write constraints.decelerate_on_cancel: true and constraints.JOINT.max_deceleration_on_cancel"},
    {kTrajectory, "write_op_modes", "write command_interfaces: [position]"},
    {kTrajectory, "joint_trajectory_action.*", "the action is always offered; leave the line out"},
    {kTrajectory, "gains.*.i_clamp", "write i_clamp_max and i_clamp_min"},
    {kTrajectory, "gains.*.antiwindup",
     "write antiwindup_strategy: none | back_calculation | conditional_integration"},
    {kTrajectory, "gains.*.normalize_error",
     "a joint of type continuous in the URDF takes the shortest turn by itself; leave the line out"},
    {kTrajectory, "gains.*.angle_wraparound",
     "a joint of type continuous in the URDF takes the shortest turn by itself; leave the line out"},
    {kTrajectory, "velocity_ff.*", "write gains.JOINT.ff_velocity_scale"},
    {"pid_controller/PidController", "gains.*.i_clamp", "write i_clamp_max and i_clamp_min"},
    {"pid_controller/PidController", "gains.*.antiwindup",
     "write antiwindup_strategy: none | back_calculation | conditional_integration"},
    {"pid_controller/PidController", "enable_feedforward",
     "write gains.DOF.feedforward_gain; 0 switches it off"},
    {kStates, "publish_rate", "write update_rate, in updates a second"},
    {kStates, "publish_dynamic_joint_states",
     "interfaces other than position, velocity and effort come from a "
     "state_interfaces_broadcaster/StateInterfacesBroadcaster"},
    {kSteering, "use_stamped_vel", "Twist and TwistStamped are both understood; leave the line out"},
    {kSteering, "front_steering", "name the wheels: steering_joints_names and traction_joints_names"},
    {kSteering, "front_wheels_names", "write steering_joints_names or traction_joints_names"},
    {kSteering, "rear_wheels_names", "write steering_joints_names or traction_joints_names"},
    {"*/*", "thread_priority", "write async_parameters.thread_priority"},

    {kManager, "configure_components_on_start",
     "write hardware_components_initial_state: inactive: [NAME, …]"},
    {kManager, "activate_components_on_start",
     "every component starts active; name the others in hardware_components_initial_state: inactive or "
     "unconfigured"},
    {kManager, "autostart_components",
     "every component starts active; name the others in hardware_components_initial_state: inactive or "
     "unconfigured"},
    {kManager, "autoconfigure_components", "write hardware_components_initial_state: inactive: [NAME, …]"},
    {kManager, "robot_description", "the description is given as a file: polyarm run --description FILE"},

    {"joint_state_controller/JointStateController", "type",
     "write joint_state_broadcaster/JointStateBroadcaster"},
    {"position_controllers/JointGroupPositionController", "type",
     "write forward_command_controller/ForwardCommandController and interface_name: position"},
    {"velocity_controllers/JointGroupVelocityController", "type",
     "write forward_command_controller/ForwardCommandController and interface_name: velocity"},
    {"effort_controllers/JointGroupEffortController", "type",
     "write forward_command_controller/ForwardCommandController and interface_name: effort"},
    {"position_controllers/JointPositionController", "type",
     "write forward_command_controller/ForwardCommandController, joints: [NAME] and interface_name: "
     "position"},
    {"velocity_controllers/JointVelocityController", "type",
     "write forward_command_controller/ForwardCommandController, joints: [NAME] and interface_name: "
     "velocity"},
    {"effort_controllers/JointEffortController", "type",
     "write forward_command_controller/ForwardCommandController, joints: [NAME] and interface_name: effort"},
    {"effort_controllers/Joint*Controller", "type",
     "write pid_controller/PidController, or joint_trajectory_controller/JointTrajectoryController with "
     "command_interfaces: [effort]"},
    {"velocity_controllers/Joint*Controller", "type",
     "write pid_controller/PidController, or joint_trajectory_controller/JointTrajectoryController with "
     "command_interfaces: [velocity]"},
    {"position_controllers/JointTrajectoryController", "type",
     "write joint_trajectory_controller/JointTrajectoryController with command_interfaces: [position]"},
    {"*_controllers/GripperActionController", "type",
     "write parallel_gripper_action_controller/GripperActionController"},
    {"forward_command_controller/ForwardJointGroupCommandController", "type",
     "write forward_command_controller/ForwardCommandController"},
    {"imu_sensor_controller/*", "type", "write imu_sensor_broadcaster/IMUSensorBroadcaster"},
    {"force_torque_sensor_controller/*", "type",
     "write force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"},
};
}  // namespace

bool matches_pattern(std::string_view pattern, std::string_view text) noexcept {
  std::size_t p = 0, t = 0, star = std::string_view::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p, ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

std::span<const Superseded> superseded_keys() {
  return kRows;
}

const char* superseded(std::string_view type, std::string_view key) noexcept {
  for (const Superseded& row : kRows)
    if (matches_pattern(row.key, key) && matches_pattern(row.type, type)) return row.instead;
  return nullptr;
}

const char* superseded_type(std::string_view type) noexcept {
  return superseded(type, "type");
}

}  // namespace polyarm::ros_files
