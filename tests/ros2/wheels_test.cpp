/// A steered base in ROS 2's graph: topics, transforms and services of its controller; a battery beside it.
#include <cmath>

#include "tests/ros2/own_cell.hpp"

namespace polyarm::ros2 {
namespace {

using test::json;
using test::wait;

const char* const kTruck = R"(<robot name="truck">
  <link name="base_link"/><link name="r"/><link name="l"/><link name="s"/>
  <joint name="right" type="continuous"><parent link="base_link"/><child link="r"/><axis xyz="0 1 0"/><limit velocity="20" effort="1"/></joint>
  <joint name="left" type="continuous"><parent link="base_link"/><child link="l"/><axis xyz="0 1 0"/><limit velocity="20" effort="1"/></joint>
  <joint name="steering" type="revolute"><parent link="base_link"/><child link="s"/><axis xyz="0 0 1"/><limit lower="-1.3" upper="1.3" velocity="5" effort="1"/></joint>
  <ros2_control name="truck" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin><param name="calculate_dynamics">true</param></hardware>
    <joint name="right"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <joint name="left"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <joint name="steering"><command_interface name="position"/><state_interface name="position"/></joint>
    <sensor name="cell_1"><state_interface name="battery_voltage"><param name="initial_value">24.5</param></state_interface></sensor>
  </ros2_control></robot>)";
const char* const kTruckControllers = R"(controller_manager:
  ros__parameters:
    update_rate: 100
    truck: {type: tricycle_steering_controller/TricycleSteeringController}
    batteries: {type: battery_state_broadcaster/BatteryStateBroadcaster}
truck:
  ros__parameters:
    traction_joints_names: [right, left]
    steering_joints_names: [steering]
    wheelbase: 0.9
    traction_track_width: 0.6
    traction_wheels_radius: 0.1
batteries:
  ros__parameters: {batteries: [cell_1], cell_1: {minimum_voltage: 20.0, maximum_voltage: 29.0}}
)";

TEST(Ros2Wheels, AreDrivenAndReportedAsInRos) {
  test::OwnCell cell({{"truck.urdf", kTruck},
                      {"controllers.yaml", kTruckControllers},
                      {"cell.yaml",
                       "polyarm: cell/1\nrobots:\n  arm: {model: truck.urdf, hardware: mock}\n"
                       "controllers: controllers.yaml\n"}});
  const auto odometry = cell.client->listen("/truck/odometry", "nav_msgs/Odometry");
  const auto plain_odometry = cell.client->listen("/odom", "nav_msgs/Odometry");
  const auto frames = cell.client->listen("/truck/tf_odometry", "tf2_msgs/TFMessage", {true, false, 100});
  const auto tf = cell.client->listen("/tf", "tf2_msgs/TFMessage", {true, false, 100});
  const auto state = cell.client->listen("/truck/controller_state", "control_msgs/SteeringControllerStatus");
  const auto battery = cell.client->listen("/batteries/battery_state", "sensor_msgs/BatteryState");
  const auto each = cell.client->listen("/batteries/raw_battery_states", "control_msgs/BatteryStateArray");
  const auto reference = cell.client->publish("/truck/reference", "geometry_msgs/TwistStamped");
  ASSERT_TRUE(wait([&] { return reference->matched() && odometry->heard(); }));
  EXPECT_TRUE(wait([&] {
    reference->publish({{"twist", {{"linear", {{"x", 0.3}}}, {"angular", {{"z", 0.1}}}}}});
    return odometry->latest()["pose"]["pose"]["position"]["y"].get<double>() > 0.01;
  })) << odometry->latest();
  EXPECT_TRUE(wait([&] { return plain_odometry->heard() && frames->heard() && state->heard(); }));
  EXPECT_TRUE(wait([&] {
    const json latest = tf->latest();
    return latest.is_object() && latest["transforms"][0]["child_frame_id"] == "base_link";
  })) << tf->latest();
  EXPECT_EQ(frames->latest()["transforms"][0]["header"]["frame_id"], "odom");
  EXPECT_NEAR(state->latest()["steering_angle_command"][0].get<double>(), std::atan(0.1 * 0.9 / 0.3), 1e-9);
  EXPECT_EQ(state->latest()["linear_velocity_command"].size(), 2u);
  EXPECT_TRUE(
      cell.call("/truck/set_odometry", "control_msgs/srv/SetOdometry", {{"x", 50}, {"yaw", 1}})["success"]);
  EXPECT_TRUE(wait([&] { return odometry->latest()["pose"]["pose"]["position"]["x"].get<double>() > 49; }))
      << odometry->latest();
  cell.call("/truck/reset_odometry", "std_srvs/srv/Empty");
  EXPECT_TRUE(wait([&] { return odometry->latest()["pose"]["pose"]["position"]["x"].get<double>() < 40; }));
  ASSERT_TRUE(wait([&] { return battery->heard() && each->heard(); }));
  EXPECT_NEAR(battery->latest()["percentage"].get<double>(), 50, 1e-3);
  EXPECT_EQ(battery->latest()["present"], true);
  EXPECT_NEAR(each->latest()["battery_states"][0]["voltage"].get<double>(), 24.5, 1e-3);
}

}  // namespace
}  // namespace polyarm::ros2
