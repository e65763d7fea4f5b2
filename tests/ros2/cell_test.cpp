/// The command with --ros2, from outside.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/ros2/domain.hpp"
#include "tests/ros2/process.hpp"
#include "tests/ros2/ros2_cell.hpp"
#ifdef POLYARM_CYCLONE
#include "messages.h"
#include "tests/ros2/cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

using test::Client;
using test::json;
using test::wait;

TEST_F(Ros2Cell, TellsWhatRvizNeeds) {
  const auto states = client_->listen("/joint_states", "sensor_msgs/JointState");
  const auto description = client_->listen("/robot_description", "std_msgs/String", {true, true, 1});
  const auto frames = client_->listen("/tf", "tf2_msgs/TFMessage", {true, false, 100});
  const auto fixed = client_->listen("/tf_static", "tf2_msgs/TFMessage", {true, true, 1});
  ASSERT_TRUE(
      wait([&] { return states->heard() && description->heard() && frames->heard() && fixed->heard(); }));
  EXPECT_EQ(states->latest()["name"].size(), 6u);
  EXPECT_EQ(states->latest()["name"][0], "shoulder_pan_joint");
  const std::int64_t age =
      std::time(nullptr) - states->latest()["header"]["stamp"]["sec"].get<std::int64_t>();
  EXPECT_LE(std::abs(age), 5) << "stamps are not those of the system's clock";
  EXPECT_NE(description->latest()["data"].get<std::string>().find("<robot"), std::string::npos);
  EXPECT_EQ(frames->latest()["transforms"].size(), 6u);
  std::set<std::string> children{"world"};
  const json all[] = {frames->latest(), fixed->latest()};
  for (const json& list : all)
    for (const json& t : list["transforms"]) children.insert(t["child_frame_id"]);
  for (const json& list : all)
    for (const json& t : list["transforms"])
      EXPECT_TRUE(children.contains(t["header"]["frame_id"])) << t << " hangs on nothing";
  EXPECT_TRUE(children.contains("tool0"));
}

TEST_F(Ros2Cell, FollowsAGoalWithFeedbackAndResult) {
  const auto states = client_->listen("/joint_states", "sensor_msgs/JointState");
  const auto feedback = client_->listen(kAction + "feedback", kType + "_FeedbackMessage");
  const auto status = client_->listen(kAction + "status", "action_msgs/GoalStatusArray", {true, true, 1});
  ASSERT_TRUE(wait([&] { return states->heard(); }));
  const json sent =
      call(kAction + "send_goal", kType + "_SendGoal", {{"goal_id", id(1)}, {"goal", goal_to(0.5, 1)}});
  ASSERT_TRUE(sent["accepted"].get<bool>());
  const json result = call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(1)}});
  EXPECT_EQ(result["status"], 4) << result;
  EXPECT_EQ(result["result"]["error_code"], 0);
  ASSERT_TRUE(feedback->heard());
  EXPECT_EQ(feedback->latest()["goal_id"], id(1));
  EXPECT_EQ(feedback->latest()["feedback"]["actual"]["positions"].size(), 6u);
  EXPECT_TRUE(wait([&] { return status->latest()["status_list"][0]["status"] == 4; })) << status->latest();
  EXPECT_TRUE(wait([&] { return std::abs(states->latest()["position"][0].get<double>() - 0.5) < 1e-3; }));
}

TEST_F(Ros2Cell, RefusesCancelsAndReplacesGoals) {
  json wrong = goal_to(0.5, 1);
  wrong["trajectory"]["joint_names"][0] = "no_such_joint";
  const auto send = [&](int n, const json& goal) {
    return call(kAction + "send_goal", kType + "_SendGoal", {{"goal_id", id(n)}, {"goal", goal}})["accepted"]
        .get<bool>();
  };
  const auto result = [&](int n) {
    return call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(n)}})["status"].get<int>();
  };
  EXPECT_FALSE(send(1, wrong));
  EXPECT_EQ(result(1), 0) << "of a goal that nobody knows";
  ASSERT_TRUE(send(2, goal_to(1.0, 20)));
  EXPECT_FALSE(send(2, goal_to(1.0, 20))) << "the same id again";
  const json cancelled =
      call(kAction + "cancel_goal", "action_msgs/srv/CancelGoal", {{"goal_info", {{"goal_id", id(2)}}}});
  EXPECT_EQ(cancelled["return_code"], 0);
  ASSERT_EQ(cancelled["goals_canceling"].size(), 1u);
  EXPECT_EQ(result(2), 5);
  const auto code = [&](int n) {
    return call(kAction + "cancel_goal", "action_msgs/srv/CancelGoal",
                {{"goal_info", {{"goal_id", id(n)}}}})["return_code"];
  };
  EXPECT_EQ(code(2), 3) << "over";
  EXPECT_EQ(code(9), 2) << "unknown";
  ASSERT_TRUE(send(3, goal_to(1.0, 20)));
  ASSERT_TRUE(send(4, goal_to(0.2, 1)));
  EXPECT_EQ(result(3), 6) << "another took its place";
  EXPECT_EQ(result(4), 4);
}

TEST_F(Ros2Cell, SwitchesControllersAsTheToolsDo) {
  EXPECT_EQ(states()["arm_controller"], "active");
  const auto activity = client_->listen("/controller_manager/activity",
                                        "controller_manager_msgs/ControllerManagerActivity", {true, true, 1});
  const auto change = [&](const char* on, const char* off) {
    return call("/controller_manager/switch_controller", "controller_manager_msgs/srv/SwitchController",
                {{"activate_controllers", json::array({on})},
                 {"deactivate_controllers", json::array({off})},
                 {"strictness", 2}});
  };
  EXPECT_TRUE(change("forward", "arm_controller")["ok"].get<bool>());
  EXPECT_EQ(states()["forward"], "active");
  EXPECT_EQ(states()["arm_controller"], "inactive");
  const json refused = change("nothing", "forward");
  EXPECT_FALSE(refused["ok"].get<bool>());
  EXPECT_NE(refused["message"].get<std::string>().find("nothing"), std::string::npos) << refused;
  const auto states = client_->listen("/joint_states", "sensor_msgs/JointState");
  const auto commands = client_->publish("/forward/commands", "std_msgs/Float64MultiArray");
  ASSERT_TRUE(wait([&] { return commands->matched() && states->heard(); }));
  EXPECT_TRUE(wait([&] {
    commands->publish({{"data", {0.01, -1.57, 1.57, -1.57, -1.57, 0}}});
    return std::abs(states->latest()["position"][0].get<double>() - 0.01) < 1e-6;
  })) << states->latest();
  EXPECT_TRUE(wait([&] {
    const json latest = activity->latest();
    if (!latest.is_object()) return false;
    for (const json& c : latest["controllers"])
      if (c["name"] == "forward" && c["state"]["label"] == "active") return true;
    return false;
  }));
  EXPECT_EQ(call("/forward/get_state", "lifecycle_msgs/srv/GetState")["current_state"]["label"], "active");
}

TEST_F(Ros2Cell, ASwitchThatStatesNoStrictnessLeavesOutWhatCannotBeAndSaysSo) {
  const auto change = [&](const json& on, const json& off) {
    return call("/controller_manager/switch_controller", "controller_manager_msgs/srv/SwitchController",
                {{"activate_controllers", on}, {"deactivate_controllers", off}});
  };
  const json taken = change({"forward"}, json::array());
  EXPECT_FALSE(taken["ok"].get<bool>()) << "its joints are held by another";
  EXPECT_NE(taken["message"].get<std::string>().find("arm_controller"), std::string::npos) << taken;
  EXPECT_EQ(states()["forward"], "inactive");
  const json twice = change({"arm_controller"}, {"forward"});
  EXPECT_TRUE(twice["ok"].get<bool>()) << "both are so already: " << twice;
  const json done = change({"forward", "nothing"}, {"arm_controller"});
  EXPECT_TRUE(done["ok"].get<bool>()) << done;
  EXPECT_EQ(states()["forward"], "active");
  EXPECT_NE(change({"arm_controller"}, {"forward"})["message"], "") << "a switch that is done says so";
}

TEST_F(Ros2Cell, WhoBeginsToListenIsToldNothingOld) {
  // Nobody has asked for these before: they are filled from now on.
  const auto states = client_->listen("/dynamic_joint_states", "control_msgs/DynamicJointState");
  ASSERT_TRUE(wait([&] { return states->heard(); }));
  const json first = states->since(0).front();
  EXPECT_EQ(first["joint_names"][0], "shoulder_pan_joint") << "as joint_states call it";
  const std::int64_t age = std::time(nullptr) - first["header"]["stamp"]["sec"].get<std::int64_t>();
  EXPECT_LE(std::abs(age), 1);
  double most = 0;
  for (const json& joint : first["interface_values"])
    for (const json& value : joint["values"]) most = std::max(most, std::abs(value.get<double>()));
  EXPECT_GT(most, 0.1) << "a UR5e does not stand at zero";
}

TEST_F(Ros2Cell, ListsHardwareAndInterfacesByTheNamesOfItsFiles) {
  const json components = call("/controller_manager/list_hardware_components",
                               "controller_manager_msgs/srv/ListHardwareComponents")["component"];
  ASSERT_EQ(components.size(), 1u);
  EXPECT_EQ(components[0]["state"]["label"], "active");
  EXPECT_EQ(components[0]["command_interfaces"][0]["name"], "shoulder_pan_joint/position");
  EXPECT_TRUE(components[0]["command_interfaces"][0]["is_claimed"].get<bool>());
  for (const json& c : call("/controller_manager/list_controllers",
                            "controller_manager_msgs/srv/ListControllers")["controller"])
    if (c["name"] == "arm_controller") {
      EXPECT_EQ(c["claimed_interfaces"][0], "shoulder_pan_joint/position");
    }
}

TEST_F(Ros2Cell, HasParametersThatCanBeListedReadAndSet) {
  const std::string types = "rcl_interfaces/srv/";
  const json listed = call("/arm_controller/list_parameters", types + "ListParameters")["result"]["names"];
  EXPECT_NE(std::find(listed.begin(), listed.end(), "constraints.goal_time"), listed.end()) << listed;
  const auto get = [&](const char* name) {
    return call("/arm_controller/get_parameters", types + "GetParameters", {{"names", {name}}})["values"][0];
  };
  EXPECT_EQ(get("constraints.goal_time")["double_value"], 0.5);
  EXPECT_EQ(get("joints")["string_array_value"].size(), 6u);
  EXPECT_EQ(get("nothing")["type"], 0);
  const auto set = [&](const char* name, const json& value) {
    return call("/arm_controller/set_parameters", types + "SetParameters",
                {{"parameters", json::array({{{"name", name}, {"value", value}}})}})["results"][0];
  };
  const json done = set("constraints.goal_time", {{"type", 3}, {"double_value", 2.5}});
  EXPECT_TRUE(done["successful"].get<bool>()) << done;
  EXPECT_EQ(get("constraints.goal_time")["double_value"], 2.5);
  const json refused = set("joints", {{"type", 9}, {"string_array_value", {"a"}}});
  EXPECT_FALSE(refused["successful"].get<bool>());
  EXPECT_NE(refused["reason"], "");
  const json taken_away = set("constraints.goal_time", {{"type", 0}});
  EXPECT_FALSE(taken_away["successful"].get<bool>());
  EXPECT_NE(taken_away["reason"].get<std::string>().find("cannot be removed"), std::string::npos)
      << taken_away;
  EXPECT_TRUE(call("/arm_controller/describe_parameters", types + "DescribeParameters",
                   {{"names", {"joints"}}})["descriptors"][0]["read_only"]
                  .get<bool>());
}

TEST_F(Ros2Cell, IsStoppedHeldAndResumed) {
  ASSERT_TRUE(call(kAction + "send_goal", kType + "_SendGoal",
                   {{"goal_id", id(1)}, {"goal", goal_to(0.5, 2)}})["accepted"]
                  .get<bool>());
  EXPECT_TRUE(call("/polyarm/hold", "std_srvs/srv/Trigger")["success"].get<bool>());
  const auto diagnostics = client_->listen("/diagnostics", "diagnostic_msgs/DiagnosticArray");
  EXPECT_TRUE(wait([&] {
    return diagnostics->heard() && diagnostics->latest()["status"][0]["message"] == "held";
  })) << diagnostics->latest();
  EXPECT_TRUE(call("/polyarm/resume", "std_srvs/srv/Trigger")["success"].get<bool>());
  EXPECT_EQ(call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(1)}})["status"], 4);
}

TEST_F(Ros2Cell, AClientThatIsKilledWithAGoalUnderWayHarmsNobody) {
  const json goal{{"goal_id", id(1)}, {"goal", goal_to(0.5, 1)}};
  test::Process client(
      {"goal", std::to_string(domain_), "/arm_controller/follow_joint_trajectory", goal.dump()});
  ASSERT_TRUE(client.has_output()) << "it was not accepted";
  client.kill();
  EXPECT_EQ(call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(1)}})["status"], 4);
}

TEST_F(Ros2Cell, RubbishEndsNeitherCellNorDoor) {
  Participant& wire = client_->participant();
  const auto goals =
      wire.add_writer("rq" + kAction + "send_goalRequest",
                      "control_msgs::action::dds_::FollowJointTrajectory_SendGoal_Request_", {}, "");
  const auto trajectories = wire.add_writer("rt/arm_controller/joint_trajectory",
                                            "trajectory_msgs::msg::dds_::JointTrajectory_", {}, "");
  ASSERT_TRUE(wait([&] { return !wire.matched(goals).empty() && !wire.matched(trajectories).empty(); }));
  std::uint32_t seed = 1;
  for (int round = 0; round < 500; ++round) {
    std::vector<std::byte> payload(4 + seed % 200);
    for (std::byte& byte : payload) byte = static_cast<std::byte>((seed = seed * 1664525 + 1013904223) >> 24);
    payload[0] = payload[2] = payload[3] = std::byte{0};
    payload[1] = std::byte{1};
    wire.write(round % 2 == 0 ? goals : trajectories, payload);
  }
  EXPECT_EQ(states()["arm_controller"], "active");
  EXPECT_TRUE(call(kAction + "send_goal", kType + "_SendGoal",
                   {{"goal_id", id(1)}, {"goal", goal_to(0.5, 1)}})["accepted"]
                  .get<bool>());
}

TEST_F(Ros2Cell, NoSocketIsOpenBeyondThisMachine) {
  // Addresses of the UDP sockets of the command's process, from the kernel's own list; 0100007F is 127.0.0.1.
  const auto states = client_->listen("/joint_states", "sensor_msgs/JointState");
  ASSERT_TRUE(wait([&] { return states->heard(); }));
  std::ifstream list("/proc/net/udp");
  std::string line, local;
  const unsigned first = 7400 + 250 * domain_;
  int ours = 0;
  for (std::getline(list, line); std::getline(list, line);) {
    std::istringstream words(line);
    words >> local >> local;
    const unsigned port = static_cast<unsigned>(std::stoul(local.substr(9), nullptr, 16));
    if (port < first || port >= first + 250) continue;
    ++ours;
    // Multicast of the discovery is joined on loopback alone, and bound to its own group.
    EXPECT_TRUE(local.starts_with("0100007F") || local.starts_with("0100FFEF")) << local;
  }
  EXPECT_GT(ours, 0);
}

#ifdef POLYARM_CYCLONE
/// A client on Cyclone DDS, with its own CDR of the same fields, beside the one on Fast DDS.
TEST_F(Ros2Cell, AClientOnCycloneSendsGoalsAndSwitchesBesideOneOnFastDds) {
  using namespace polyarm::ros2::test;
  const Cyclone cyclone(domain_);
  CycloneCaller<control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request_,
                control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response_>
      send(cyclone, kAction + "send_goal",
           control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request__desc,
           control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response__desc);
  CycloneCaller<control_msgs_action_dds__FollowJointTrajectory_GetResult_Request_,
                control_msgs_action_dds__FollowJointTrajectory_GetResult_Response_>
      result(cyclone, kAction + "get_result",
             control_msgs_action_dds__FollowJointTrajectory_GetResult_Request__desc,
             control_msgs_action_dds__FollowJointTrajectory_GetResult_Response__desc);
  CycloneCaller<controller_manager_msgs_srv_dds__SwitchController_Request_,
                controller_manager_msgs_srv_dds__SwitchController_Response_>
      change(cyclone, "/controller_manager/switch_controller",
             controller_manager_msgs_srv_dds__SwitchController_Request__desc,
             controller_manager_msgs_srv_dds__SwitchController_Response__desc);
  ASSERT_TRUE(wait([&] { return send.ready() && result.ready() && change.ready(); }));

  const char* joints[] = {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
                          "wrist_1_joint",      "wrist_2_joint",       "wrist_3_joint"};
  double there[] = {0.3, -1.5, 1.5, -1.5, -1.5, 0};
  control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request_ goal{};
  goal.uuid[3] = 9;
  std::string nothing;
  goal.trajectory.header.frame_id = goal.multi_dof_trajectory.header.frame_id = nothing.data();
  goal.trajectory.joint_names._buffer = const_cast<char**>(joints);
  goal.trajectory.joint_names._length = goal.trajectory.joint_names._maximum = 6;
  trajectory_msgs_msg_dds__JointTrajectoryPoint_ point{};
  point.positions._buffer = there;
  point.positions._length = point.positions._maximum = 6;
  point.time_from_start.sec = 1;
  goal.trajectory.points._buffer = &point;
  goal.trajectory.points._length = goal.trajectory.points._maximum = 1;
  send.ask(goal);
  ASSERT_TRUE(wait([&] { return send.answered([](const auto& reply) { EXPECT_TRUE(reply.accepted); }); }));
  EXPECT_EQ(states()["arm_controller"], "active") << "asked by the other client meanwhile";
  control_msgs_action_dds__FollowJointTrajectory_GetResult_Request_ asked{};
  asked.uuid[3] = 9;
  result.ask(asked);
  ASSERT_TRUE(wait([&] {
    return result.answered([](const auto& reply) {
      EXPECT_EQ(reply.status, 4);
      EXPECT_EQ(reply.error_code, 0);
    });
  }));
  controller_manager_msgs_srv_dds__SwitchController_Request_ request{};
  char* names[] = {const_cast<char*>("arm_controller")};
  request.deactivate_controllers._buffer = names;
  request.deactivate_controllers._length = request.deactivate_controllers._maximum = 1;
  request.strictness = 2;
  change.ask(request);
  ASSERT_TRUE(wait(
      [&] { return change.answered([](const auto& reply) { EXPECT_TRUE(reply.ok) << reply.message; }); }));
  EXPECT_EQ(states()["arm_controller"], "inactive");
}
#endif

/// The example with two wheels: driven by both kinds of twist, at its own name and at /cmd_vel.
TEST(Ros2Jetbot, IsDrivenByTwistsWithAndWithoutStamp) {
  const std::uint32_t domain = test::own_domain();
  ::setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  const polyarm::test::ExampleCopy copy("jetbot");
  polyarm::test::Command command({"run", copy.path(), "--ros2", "--no-socket"});
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  Client client(domain);
  const auto odometry = client.listen("/odom", "nav_msgs/Odometry");
  const auto frames = client.listen("/tf", "tf2_msgs/TFMessage", {true, false, 100});
  const auto stamped = client.publish("/jetbot_base_controller/cmd_vel", "geometry_msgs/TwistStamped");
  const auto plain = client.publish("/cmd_vel", "geometry_msgs/Twist");
  ASSERT_TRUE(wait([&] { return stamped->matched() && plain->matched() && odometry->heard(); }));
  const auto speed = [&] { return odometry->latest()["twist"]["twist"]["linear"]["x"].get<double>(); };
  EXPECT_TRUE(wait([&] {
    stamped->publish({{"twist", {{"linear", {{"x", 0.1}}}}}});
    return speed() > 0.005;
  })) << odometry->latest();
  EXPECT_TRUE(wait([&] { return std::abs(speed()) < 1e-4; })) << "nobody drives, and it goes on";
  EXPECT_TRUE(wait([&] {
    plain->publish({{"linear", {{"x", -0.1}}}});
    return speed() < -0.005;
  }));
  EXPECT_TRUE(wait([&] {
    const json latest = frames->latest();
    return latest.is_object() && latest["transforms"][0]["header"]["frame_id"] == "odom";
  })) << frames->latest();
  const auto fixed = client.listen("/tf_static", "tf2_msgs/TFMessage", {true, true, 1});
  EXPECT_TRUE(wait([&] { return fixed->heard(); }));
  for (const json& each : fixed->latest()["transforms"])
    EXPECT_NE(each["header"]["frame_id"], "world") << "the base's place is the odometry's matter alone";
}

}  // namespace
}  // namespace polyarm::ros2
