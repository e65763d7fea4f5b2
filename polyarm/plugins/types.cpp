#include "polyarm/plugins/types.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/battery_state_broadcaster.hpp"
#include "polyarm/broadcasters/chained_filter.hpp"
#include "polyarm/broadcasters/force_torque_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/gpio_command_controller.hpp"
#include "polyarm/broadcasters/gps_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/imu_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/joint_state_broadcaster.hpp"
#include "polyarm/broadcasters/magnetometer_broadcaster.hpp"
#include "polyarm/broadcasters/pose_broadcaster.hpp"
#include "polyarm/broadcasters/range_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/state_interfaces_broadcaster.hpp"
#include "polyarm/force/admittance_controller.hpp"
#include "polyarm/joint_control/forward_command_controller.hpp"
#include "polyarm/joint_control/gripper_action_controller.hpp"
#include "polyarm/joint_control/joint_pid_controller.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/joint_control/pid_controller.hpp"
#include "polyarm/joint_control/simple_trajectory_controller.hpp"
#include "polyarm/wheels/diff_drive_controller.hpp"
#include "polyarm/wheels/mecanum_drive_controller.hpp"
#include "polyarm/wheels/omni_wheel_drive_controller.hpp"
#include "polyarm/wheels/steering_controllers.hpp"
#include "polyarm/wheels/tricycle_controller.hpp"

namespace polyarm::controllers {

namespace {
template <typename T>
std::unique_ptr<Controller> make() {
  return std::make_unique<T>();
}
using Forward = ForwardCommandController;
using Trajectory = JointTrajectoryController;

std::vector<ControllerType>& types() {
  static std::vector<ControllerType> table = {
      {"joint_trajectory_controller/JointTrajectoryController", make<Trajectory>,
       "follows trajectories of any number of joints"},
      {"position_controllers/JointTrajectoryController",
       make<Trajectory>,
       "the same, commanding positions",
       {{"command_interfaces", "position"}}},
      {"ros2_control_demo_example_7/RobotController", make<SimpleTrajectoryController>,
       "the simple controller of ros2_control's example 7: from point to point by time"},
      {"joint_state_broadcaster/JointStateBroadcaster", make<JointStateBroadcaster>,
       "publishes the states of the joints"},
      {"joint_state_controller/JointStateController", make<JointStateBroadcaster>,
       "publishes the states of the joints (ros_control's name)"},
      {"diff_drive_controller/DiffDriveController", make<DiffDriveController>,
       "drives a base with wheels on two sides"},
      {"bicycle_steering_controller/BicycleSteeringController", make<BicycleSteeringController>,
       "drives a base with one traction wheel and one steering joint"},
      {"tricycle_steering_controller/TricycleSteeringController", make<TricycleSteeringController>,
       "drives a base with two traction wheels and one steering joint"},
      {"ackermann_steering_controller/AckermannSteeringController", make<AckermannSteeringController>,
       "drives a base with two traction wheels and two steering joints"},
      {"tricycle_controller/TricycleController", make<TricycleController>,
       "drives a base whose front wheel steers and drives"},
      {"mecanum_drive_controller/MecanumDriveController", make<MecanumDriveController>,
       "drives a base with four mecanum wheels, sideways too"},
      {"omni_wheel_drive_controller/OmniWheelDriveController", make<OmniWheelDriveController>,
       "drives a base with three or more omni wheels, sideways too"},
      {"admittance_controller/AdmittanceController", make<AdmittanceController>,
       "makes joints yield to forces at a sensor; used in a chain"},
      {"imu_sensor_broadcaster/IMUSensorBroadcaster", make<ImuSensorBroadcaster>,
       "publishes the measurements of an IMU"},
      {"imu_sensor_controller/ImuSensorController", make<ImuSensorBroadcaster>,
       "publishes the measurements of an IMU (ros_control's name)"},
      {"force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster", make<ForceTorqueSensorBroadcaster>,
       "publishes forces and torques"},
      {"force_torque_sensor_controller/ForceTorqueSensorController", make<ForceTorqueSensorBroadcaster>,
       "publishes forces and torques (ros_control's name)"},
      {"gps_sensor_broadcaster/GPSSensorBroadcaster", make<GpsSensorBroadcaster>,
       "publishes the position of a satellite receiver"},
      {"pose_broadcaster/PoseBroadcaster", make<PoseBroadcaster>, "publishes a pose that a sensor measures"},
      {"range_sensor_broadcaster/RangeSensorBroadcaster", make<RangeSensorBroadcaster>,
       "publishes a measured distance"},
      {"magnetometer_broadcaster/MagnetometerBroadcaster", make<MagnetometerBroadcaster>,
       "publishes a measured magnetic field"},
      {"battery_state_broadcaster/BatteryStateBroadcaster", make<BatteryStateBroadcaster>,
       "publishes the state of batteries"},
      {"chained_filter_controller/ChainedFilter", make<ChainedFilter>,
       "filters states and exports the results"},
      {"state_interfaces_broadcaster/StateInterfacesBroadcaster", make<StateInterfacesBroadcaster>,
       "publishes any states"},
      {"gpio_controllers/GpioCommandController", make<GpioCommandController>,
       "writes and publishes the values of gpios"},
      {"forward_command_controller/ForwardCommandController", make<Forward>,
       "forwards numbers to one interface of several joints"},
      {"forward_command_controller/MultiInterfaceForwardCommandController", make<Forward>,
       "hands numbers to several interfaces of one joint"},
      {"position_controllers/JointPositionController",
       make<Forward>,
       "hands a position to one joint",
       {{"interface_name", "position"}}},
      {"position_controllers/JointGroupPositionController",
       make<Forward>,
       "hands positions to joints",
       {{"interface_name", "position"}}},
      {"velocity_controllers/JointVelocityController",
       make<Forward>,
       "hands a velocity to one joint",
       {{"interface_name", "velocity"}}},
      {"velocity_controllers/JointGroupVelocityController",
       make<Forward>,
       "hands velocities to joints",
       {{"interface_name", "velocity"}}},
      {"effort_controllers/JointPositionController",
       make<JointPidController>,
       "a joint's position through a PID to an effort",
       {{"reference", "position"}, {"command_interface", "effort"}}},
      {"effort_controllers/JointVelocityController",
       make<JointPidController>,
       "a joint's velocity through a PID to an effort",
       {{"reference", "velocity"}, {"command_interface", "effort"}}},
      {"effort_controllers/JointGroupPositionController",
       make<JointPidController>,
       "joints' positions through PIDs to efforts",
       {{"reference", "position"}, {"command_interface", "effort"}}},
      {"effort_controllers/JointGroupVelocityController",
       make<JointPidController>,
       "joints' velocities through PIDs to efforts",
       {{"reference", "velocity"}, {"command_interface", "effort"}}},
      {"velocity_controllers/JointPositionController",
       make<JointPidController>,
       "a joint's position through a PID to a velocity",
       {{"reference", "position"}, {"command_interface", "velocity"}}},
      {"velocity_controllers/JointGroupPositionController",
       make<JointPidController>,
       "joints' positions through PIDs to velocities",
       {{"reference", "position"}, {"command_interface", "velocity"}}},
      {"effort_controllers/JointTrajectoryController",
       make<Trajectory>,
       "follows trajectories, commanding efforts",
       {{"command_interfaces", "effort"}}},
      {"velocity_controllers/JointTrajectoryController",
       make<Trajectory>,
       "follows trajectories, commanding velocities",
       {{"command_interfaces", "velocity"}}},
      {"pid_controller/PidController", make<PidController>,
       "a PID for each degree of freedom; can be used in a chain"},
      {"parallel_gripper_action_controller/GripperActionController", make<GripperActionController>,
       "opens and closes a gripper"},
      {"position_controllers/GripperActionController",
       make<GripperActionController>,
       "opens and closes a gripper",
       {{"command_interface", "position"}, {"max_effort", "0"}}},
      {"effort_controllers/GripperActionController",
       make<GripperActionController>,
       "opens and closes a gripper through a PID to an effort",
       {{"command_interface", "effort"}, {"max_effort", "0"}}},
      {"effort_controllers/JointEffortController",
       make<Forward>,
       "hands an effort to one joint",
       {{"interface_name", "effort"}}},
      {"effort_controllers/JointGroupEffortController",
       make<Forward>,
       "hands efforts to joints",
       {{"interface_name", "effort"}}},
  };
  return table;
}
}  // namespace

const std::vector<ControllerType>& controller_types() {
  return types();
}

void register_controller_type(ControllerType type) {
  types().push_back(std::move(type));
}

const ControllerType* find_controller_type(const std::string& name) {
  for (const ControllerType& type : controller_types())
    if (name == type.name) return &type;
  return nullptr;
}

std::vector<std::string> controller_type_names() {
  std::vector<std::string> out;
  for (const ControllerType& type : controller_types()) out.push_back(type.name);
  return out;
}

bool is_publisher(const std::string& type) {
  for (const char* word : {"Broadcaster", "JointStateController", "SensorController"})
    if (type.find(word) != std::string::npos) return true;
  return false;
}

std::unique_ptr<Controller> make_controller(const std::string& name, Parameters& parameters) {
  const ControllerType* type = find_controller_type(name);
  if (!type)
    throw Error("unknown-controller-type",
                "there is no controller type '" + name + "'" + did_you_mean(name, controller_type_names()),
                "`polyarm control types` lists them");
  for (const auto& [key, value] : type->implied) parameters.set(key, {value});
  return type->make();
}

}  // namespace polyarm::controllers
