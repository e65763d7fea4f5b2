/// What tools ask of nodes beside topics and goals; and the examples on the graph.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <string>

#include "tests/ros2/domain.hpp"
#include "tests/ros2/example.hpp"
#include "tests/ros2/ros2_cell.hpp"
#ifdef POLYARM_CYCLONE
#include "messages.h"
#include "tests/ros2/cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

TEST_F(Ros2Cell, ANodeTellsWhatItsTypesLookLike) {
  const auto ask = [&](const char* type, const std::string& hash) {
    return call("/arm_controller/get_type_description", "type_description_interfaces/srv/GetTypeDescription",
                {{"type_name", type}, {"type_hash", hash}, {"include_type_sources", true}});
  };
  const std::string hash = messages::find_type("sensor_msgs/JointState")->hash;
  const json told = ask("sensor_msgs/msg/JointState", hash);
  ASSERT_TRUE(told["successful"].get<bool>()) << told;
  const json& described = told["type_description"]["type_description"];
  EXPECT_EQ(described["type_name"], "sensor_msgs/msg/JointState");
  EXPECT_EQ(described["fields"][1]["name"], "name");
  EXPECT_EQ(described["fields"][1]["type"]["type_id"], 161) << "an open sequence of texts";
  EXPECT_EQ(described["fields"][0]["type"]["nested_type_name"], "std_msgs/msg/Header");
  const json& referenced = told["type_description"]["referenced_type_descriptions"];
  ASSERT_EQ(referenced.size(), 2u) << "header and time";
  EXPECT_EQ(referenced[0]["type_name"], "builtin_interfaces/msg/Time");
  EXPECT_NE(told["type_sources"][0]["raw_file_contents"].get<std::string>().find("float64[] position"),
            std::string::npos);
  EXPECT_FALSE(ask("sensor_msgs/msg/JointState", "RIHS01_00")["successful"].get<bool>());
  EXPECT_FALSE(ask("no_msgs/msg/Thing", "")["successful"].get<bool>());
}

TEST_F(Ros2Cell, ASpawnerSetsTypeAndFileAndLoadsAController) {
  std::ofstream(folder_ / "more.yaml") << "second:\n  ros__parameters:\n    joints: [elbow_joint]\n"
                                          "    interface_name: position\n";
  const auto set = [&](const std::string& name, const json& value) {
    return call("/controller_manager/set_parameters", kParameters + "SetParameters",
                {{"parameters", json::array({{{"name", name}, {"value", value}}})}})["results"][0];
  };
  const auto text = [](const std::string& value) { return json{{"type", 4}, {"string_value", value}}; };
  EXPECT_TRUE(set("second.type", text("forward_command_controller/ForwardCommandController"))["successful"]);
  EXPECT_TRUE(set("second.params_file", text("['" + (folder_ / "more.yaml").string() + "']"))["successful"]);
  EXPECT_FALSE(set("update_rate", {{"type", 2}, {"integer_value", 5}})["successful"].get<bool>());
  const json names =
      call("/controller_manager/list_parameters", kParameters + "ListParameters")["result"]["names"];
  for (const char* name : {"arm_controller.type", "second.type", "update_rate"})
    EXPECT_TRUE(std::count(names.begin(), names.end(), name)) << name;
  EXPECT_TRUE(
      call("/controller_manager/load_controller", kManager + "LoadController", {{"name", "second"}})["ok"]);
  EXPECT_TRUE(call("/controller_manager/configure_controller", kManager + "ConfigureController",
                   {{"name", "second"}})["ok"]);
  EXPECT_EQ(states()["second"], "inactive");
  EXPECT_TRUE(call("/second/change_state", "lifecycle_msgs/srv/ChangeState",
                   {{"transition", {{"label", "cleanup"}}}})["success"]);
  EXPECT_EQ(states()["second"], "unconfigured");
  EXPECT_TRUE(call("/controller_manager/unload_controller", kManager + "UnloadController",
                   {{"name", "second"}})["ok"]);
  EXPECT_FALSE(states().contains("second"));
}

TEST_F(Ros2Cell, AGoalThatComesWhileHeldWaitsForTheResume) {
  ASSERT_TRUE(call("/polyarm/hold", "std_srvs/srv/Trigger")["success"].get<bool>());
  const auto diagnostics = client_->listen("/diagnostics", "diagnostic_msgs/DiagnosticArray");
  ASSERT_TRUE(
      wait([&] { return diagnostics->heard() && diagnostics->latest()["status"][0]["message"] == "held"; }));
  const auto joints = client_->listen("/joint_states", "sensor_msgs/JointState");
  const json sent =
      call(kAction + "send_goal", kType + "_SendGoal", {{"goal_id", id(1)}, {"goal", goal_to(0.5, 1)}});
  ASSERT_TRUE(wait([&] { return joints->heard(); }));
  const double before = joints->latest()["position"][0];
  const std::size_t heard = joints->count();
  ASSERT_TRUE(wait([&] { return joints->count() > heard + 200; }));
  EXPECT_NEAR(joints->latest()["position"][0].get<double>(), before, 1e-9) << "it moved while held";
  EXPECT_TRUE(call("/polyarm/resume", "std_srvs/srv/Trigger")["success"].get<bool>());
  if (!sent["accepted"].get<bool>()) return;
  EXPECT_EQ(call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(1)}})["status"], 4);
}

TEST_F(Ros2Cell, WhatIsRefusedIsCountedInTheDiagnostics) {
  Participant& wire = client_->participant();
  const auto writer = wire.add_writer("rt/arm_controller/joint_trajectory",
                                      "trajectory_msgs::msg::dds_::JointTrajectory_", {}, "");
  const auto diagnostics = client_->listen("/diagnostics", "diagnostic_msgs/DiagnosticArray");
  ASSERT_TRUE(wait([&] { return !wire.matched(writer).empty(); }));
  for (int i = 0; i < 5; ++i)
    wire.write(writer,
               std::vector<std::byte>{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{9}});
  EXPECT_TRUE(wait([&] {
    if (!diagnostics->heard()) return false;
    const json latest = diagnostics->latest();
    for (const json& value : latest["status"][1]["values"])
      if (value["key"] == "refused") return value["value"] == "5";
    return false;
  })) << diagnostics->latest();
}

#ifdef POLYARM_CYCLONE
/// What one of the two has begun, the other ends; what one sets, the other reads.
TEST_F(Ros2Cell, AClientOnCycloneCancelsAndSetsWhatOneOnFastDdsSees) {
  using namespace polyarm::ros2::test;
  const Cyclone cyclone(domain_);
  CycloneCaller<action_msgs_srv_dds__CancelGoal_Request_, action_msgs_srv_dds__CancelGoal_Response_> cancel(
      cyclone, kAction + "cancel_goal", action_msgs_srv_dds__CancelGoal_Request__desc,
      action_msgs_srv_dds__CancelGoal_Response__desc);
  CycloneCaller<rcl_interfaces_srv_dds__SetParameters_Request_,
                rcl_interfaces_srv_dds__SetParameters_Response_>
      set(cyclone, "/arm_controller/set_parameters", rcl_interfaces_srv_dds__SetParameters_Request__desc,
          rcl_interfaces_srv_dds__SetParameters_Response__desc);
  ASSERT_TRUE(call(kAction + "send_goal", kType + "_SendGoal",
                   {{"goal_id", id(1)}, {"goal", goal_to(1.0, 20)}})["accepted"]
                  .get<bool>());
  ASSERT_TRUE(wait([&] { return cancel.ready() && set.ready(); }));
  action_msgs_srv_dds__CancelGoal_Request_ all{};
  cancel.ask(all);
  ASSERT_TRUE(wait([&] {
    return cancel.answered([](const auto& reply) {
      EXPECT_EQ(reply.return_code, 0);
      EXPECT_EQ(reply.goals_canceling._length, 1u);
    });
  }));
  EXPECT_EQ(call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(1)}})["status"], 5);

  std::string name = "constraints.goal_time", nothing;
  rcl_interfaces_msg_dds__Parameter_ parameter{};
  parameter.name = name.data();
  parameter.value.type = 3;
  parameter.value.double_value = 1.75;
  parameter.value.string_value = nothing.data();
  rcl_interfaces_srv_dds__SetParameters_Request_ request{};
  request.parameters._buffer = &parameter;
  request.parameters._length = request.parameters._maximum = 1;
  set.ask(request);
  ASSERT_TRUE(wait([&] {
    return set.answered([](const auto& reply) {
      ASSERT_EQ(reply.results._length, 1u);
      EXPECT_TRUE(reply.results._buffer[0].successful) << reply.results._buffer[0].reason;
    });
  }));
  EXPECT_EQ(call("/arm_controller/get_parameters", kParameters + "GetParameters",
                 {{"names", {"constraints.goal_time"}}})["values"][0]["double_value"],
            1.75);
}
#endif

const char* const kSensing = R"(<robot name="hand">
  <link name="base_link"/><link name="finger_link"/>
  <joint name="finger" type="prismatic"><parent link="base_link"/><child link="finger_link"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.05" velocity="0.1" effort="10"/></joint>
  <ros2_control name="hand" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
    <joint name="finger"><command_interface name="position"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <sensor name="tilt">STATES_OF_TILT</sensor>
    <sensor name="wrist">
      <state_interface name="force.x"><param name="initial_value">3</param></state_interface>
      <state_interface name="torque.z"><param name="initial_value">-0.5</param></state_interface>
    </sensor>
  </ros2_control></robot>)";

/// A gripper and two sensors, told and asked as ROS 2 has them.
TEST(Ros2Hand, TakesGripperGoalsAndTellsItsSensors) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("polyarm_ros2_hand_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::string states, urdf = kSensing;
  for (const char* name : {"orientation.x", "orientation.y", "orientation.z", "orientation.w",
                           "angular_velocity.x", "angular_velocity.y", "angular_velocity.z",
                           "linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"})
    states += std::string("<state_interface name='") + name + "'><param name='initial_value'>" +
              (std::string(name) == "orientation.w" ? "1" : "0") + "</param></state_interface>";
  urdf.replace(urdf.find("STATES_OF_TILT"), 14, states);
  std::ofstream(folder / "hand.urdf") << urdf;
  std::ofstream(folder / "cell.yaml")
      << "polyarm: cell/1\nrate: 200\nrobots:\n  hand: {model: hand.urdf, hardware: "
         "declared}\ncontrollers: controllers.yaml\n";
  std::ofstream(folder / "controllers.yaml") << R"(controller_manager:
  ros__parameters:
    gripper: {type: parallel_gripper_action_controller/GripperActionController}
    tilting: {type: imu_sensor_broadcaster/IMUSensorBroadcaster}
    pressing: {type: force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster}
gripper:
  ros__parameters: {joint: finger}
tilting:
  ros__parameters: {sensor_name: tilt, frame_id: base_link}
pressing:
  ros__parameters: {frame_id: finger_link, interface_names: {force: {x: wrist/force.x}, torque: {z: wrist/torque.z}}}
)";
  const std::uint32_t domain = test::own_domain();
  ::setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  polyarm::test::Command command({"run", folder.string(), "--ros2", "--no-socket"});
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  Client client(domain);
  const auto imu = client.listen("/tilting/imu", "sensor_msgs/Imu");
  const auto wrench = client.listen("/pressing/wrench", "geometry_msgs/WrenchStamped");
  ASSERT_TRUE(wait([&] { return imu->heard() && wrench->heard(); }));
  EXPECT_EQ(imu->latest()["orientation"]["w"], 1.0);
  EXPECT_EQ(imu->latest()["header"]["frame_id"], "base_link");
  EXPECT_EQ(wrench->latest()["wrench"]["force"]["x"], 3.0);
  EXPECT_EQ(wrench->latest()["wrench"]["torque"]["z"], -0.5);
  const std::string action = "/gripper/gripper_cmd/_action/",
                    type = "control_msgs/action/ParallelGripperCommand";
  const json sent = client.call(
      action + "send_goal", type + "_SendGoal",
      {{"goal_id", id(5)}, {"goal", {{"command", {{"name", {"finger"}}, {"position", {0.02}}}}}}});
  ASSERT_TRUE(sent["accepted"].get<bool>());
  const json result = client.call(action + "get_result", type + "_GetResult", {{"goal_id", id(5)}});
  EXPECT_EQ(result["status"], 4) << result;
  EXPECT_TRUE(result["result"]["reached_goal"].get<bool>());
  EXPECT_NEAR(result["result"]["state"]["position"][0].get<double>(), 0.02, 0.011);
  std::filesystem::remove_all(folder);
}

TEST(Ros2Example, R6botDrawsAndIsSeen) {
  test::Example example("r6bot");
  const auto joints = example.client->listen("/joint_states", "sensor_msgs/JointState");
  const auto description = example.client->listen("/robot_description", "std_msgs/String", {true, true, 1});
  ASSERT_TRUE(wait([&] { return joints->heard() && description->heard(); }));
  EXPECT_EQ(joints->latest()["name"].size(), 6u);
  const double first = joints->latest()["position"][0];
  EXPECT_TRUE(wait([&] { return std::abs(joints->latest()["position"][0].get<double>() - first) > 0.01; }))
      << "its trajectory is under way";
  const json listed =
      example.client->call("/controller_manager/list_controllers", kManager + "ListControllers");
  std::set<std::string> names;
  for (const json& c : listed["controller"]) names.insert(c["name"]);
  EXPECT_TRUE(names.contains("r6bot_controller")) << listed;
}

#ifdef POLYARM_CYCLONE
TEST(Ros2Example, AJetbotIsDrivenByAClientOnCyclone) {
  test::Example example("jetbot");
  const auto odometry = example.client->listen("/odom", "nav_msgs/Odometry");
  const test::Cyclone cyclone(example.domain());
  const auto twists = cyclone.writer(geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel");
  ASSERT_TRUE(wait([&] { return odometry->heard(); }));
  EXPECT_TRUE(wait([&] {
    geometry_msgs_msg_dds__Twist_ twist{};
    twist.linear.x = 0.1;
    dds_write(twists, &twist);
    return odometry->latest()["twist"]["twist"]["linear"]["x"].get<double>() > 0.005;
  })) << odometry->latest();
}
#endif

TEST(Ros2Example, PickAndPlaceIsSeenAtWork) {
  test::Example example("pick_and_place");
  const auto joints = example.client->listen("/joint_states", "sensor_msgs/JointState");
  const auto frames = example.client->listen("/tf", "tf2_msgs/TFMessage", {true, false, 100});
  ASSERT_TRUE(wait([&] { return joints->heard() && frames->heard(); }));
  const json first = joints->latest()["position"];
  EXPECT_TRUE(wait([&] { return joints->latest()["position"] != first; })) << "it moves";
}

}  // namespace
}  // namespace polyarm::ros2
