/// Clients of both middlewares at once on one robot that has arm and wheels; programs by their services; and
/// a client with the transports of ROS 2's own middleware.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "tests/ros2/own_cell.hpp"
#include "tests/ros2/rmw_fast.hpp"
#include "tests/ros2/ros2_cell.hpp"
#ifdef POLYARM_CYCLONE
#include "messages.h"
#include "tests/ros2/cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

const std::string kTrigger = "std_srvs/srv/Trigger";

/// Each robot has its own description, frames and joint states; the arms are moved by their own names.
TEST(Ros2TwoArms, AreToldApart) {
  test::OwnCell cell(
      test::OwnCell::Files{{"cell.yaml",
                            "polyarm: cell/1\nrate: 500\nrobots:\n"
                            "  left: {model: universal_robots/ur5e, hardware: mock}\n"
                            "  right: {model: universal_robots/ur5e, hardware: mock, xyz: [1, 0, 0]}\n"}});
  const auto all = cell.client->listen("/joint_states", "sensor_msgs/JointState");
  const auto right = cell.client->listen("/right/joint_states", "sensor_msgs/JointState");
  const auto left = cell.client->listen("/left/joint_states", "sensor_msgs/JointState");
  const auto description =
      cell.client->listen("/right/robot_description", "std_msgs/String", {true, true, 1});
  const auto frames = cell.client->listen("/tf", "tf2_msgs/TFMessage", {true, false, 100});
  ASSERT_TRUE(wait([&] {
    return all->heard() && right->heard() && left->heard() && description->heard() && frames->heard();
  }));
  EXPECT_EQ(all->latest()["name"].size(), 12u);
  EXPECT_EQ(right->latest()["name"].size(), 6u);
  EXPECT_EQ(right->latest()["name"][0], "shoulder_pan_joint") << "as its description has it";
  std::set<std::string> parents;
  const json latest = frames->latest();
  for (const json& t : latest["transforms"]) parents.insert(t["header"]["frame_id"]);
  EXPECT_TRUE(parents.contains("left/upper_arm_link"));
  EXPECT_TRUE(parents.contains("right/upper_arm_link"));
  const std::string action = "/right_joint_trajectory_controller/follow_joint_trajectory/_action/";
  const double before = left->latest()["position"][0];
  ASSERT_TRUE(cell.call(action + "send_goal", kType + "_SendGoal",
                        {{"goal_id", id(1)}, {"goal", goal_to(0.5, 1)}})["accepted"]
                  .get<bool>());
  EXPECT_EQ(cell.call(action + "get_result", kType + "_GetResult", {{"goal_id", id(1)}})["status"], 4);
  EXPECT_TRUE(wait([&] { return std::abs(right->latest()["position"][0].get<double>() - 0.5) < 1e-3; }));
  EXPECT_EQ(left->latest()["position"][0].get<double>(), before);
}

const char* const kScript =
    "while true\n"
    "  movej joints(0deg, -90deg, 90deg, -90deg, -90deg, 0deg)\n"
    "  wait 50ms\n"
    "  movej joints(20deg, -90deg, 90deg, -90deg, -90deg, 0deg)\n"
    "  wait 50ms\n"
    "end\n";

TEST(Ros2Program, IsPausedWentOnWithEndedAndBegunAnew) {
  test::OwnCell cell(
      test::OwnCell::Files{
          {"cell.yaml",
           "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mock}\n"
           "program: job\n"},
          {"job.script", kScript}},
      {"--stay"});
  const auto joints = cell.client->listen("/joint_states", "sensor_msgs/JointState");
  const auto trigger = [&](const char* what) {
    return cell.call(std::string("/polyarm/program/") + what, kTrigger);
  };
  const auto position = [&](const json& state) { return state["position"][0].get<double>(); };
  const auto moves = [&] {
    const std::size_t before = joints->count();
    const double first = position(joints->latest());
    return wait([&] {
      for (const json& state : joints->since(before))
        if (std::abs(position(state) - first) > 0.02) return true;
      return false;
    });
  };
  // Motion that is queued goes on to its end.
  const auto comes_to_rest = [&] {
    return wait(
        [&] {
          const std::size_t count = joints->count();
          if (count < 200) return false;
          const auto last = joints->since(count - 200);
          return std::all_of(last.begin(), last.end(), [&](const json& state) {
            return std::abs(position(state) - position(last.front())) < 1e-9;
          });
        },
        120);
  };
  ASSERT_TRUE(wait([&] { return joints->heard(); }));
  EXPECT_TRUE(moves()) << "it runs from the start";
  const json running = trigger("start");
  EXPECT_FALSE(running["success"].get<bool>());
  EXPECT_NE(running["message"].get<std::string>().find("running"), std::string::npos) << running;
  EXPECT_TRUE(trigger("pause")["success"].get<bool>());
  EXPECT_TRUE(comes_to_rest());
  EXPECT_TRUE(trigger("start")["success"].get<bool>()) << "it goes on";
  EXPECT_TRUE(moves());
  EXPECT_TRUE(trigger("stop")["success"].get<bool>());
  EXPECT_TRUE(comes_to_rest());
  const json ended = trigger("pause");
  EXPECT_FALSE(ended["success"].get<bool>());
  EXPECT_NE(ended["message"].get<std::string>().find("ended"), std::string::npos) << ended;
  EXPECT_TRUE(trigger("start")["success"].get<bool>()) << "it begins anew";
  EXPECT_TRUE(moves());
}

TEST_F(Ros2Cell, AControllerTellsAndChangesItsLifeCycle) {
  const std::string types = "lifecycle_msgs/srv/";
  const auto state = [&] {
    return call("/forward/get_state", types + "GetState")["current_state"]["label"].get<std::string>();
  };
  const auto change = [&](int id) {
    return call("/forward/change_state", types + "ChangeState", {{"transition", {{"id", id}}}})["success"]
        .get<bool>();
  };
  const auto possible = [&] {
    std::set<std::string> out;
    const json all = call("/forward/get_available_transitions", types + "GetAvailableTransitions");
    for (const json& t : all["available_transitions"]) out.insert(t["transition"]["label"]);
    return out;
  };
  EXPECT_EQ(state(), "inactive");
  EXPECT_EQ(possible(), (std::set<std::string>{"activate", "cleanup"}));
  EXPECT_FALSE(change(4)) << "what is not active is not deactivated";
  EXPECT_FALSE(change(3)) << "another has the joints";
  EXPECT_EQ(state(), "inactive");
  EXPECT_TRUE(call("/controller_manager/switch_controller", kManager + "SwitchController",
                   {{"deactivate_controllers", {"arm_controller"}}, {"strictness", 2}})["ok"]
                  .get<bool>());
  EXPECT_TRUE(change(3));
  EXPECT_EQ(state(), "active");
  EXPECT_EQ(possible(), (std::set<std::string>{"deactivate"}));
  EXPECT_TRUE(change(4));
  EXPECT_EQ(state(), "inactive");
  const json all = call("/forward/get_available_states", types + "GetAvailableStates")["available_states"];
  EXPECT_EQ(all.size(), 11u) << "those between them, too";
}

#ifdef POLYARM_RMW_FAST
TEST_F(Ros2Cell, IsFoundByAClientWithTheTransportsOfRos2sOwnMiddleware) {
  using test::Bytes;
  using test::RmwNode;
  RmwNode node(domain_, RmwNode::Range::localhost);
  auto* joints = node.reader("rt/joint_states", "sensor_msgs::msg::dds_::JointState_");
  auto* sensor = node.reader("rt/joint_states", "sensor_msgs::msg::dds_::JointState_", false, false);
  auto* description = node.reader("rt/robot_description", "std_msgs::msg::dds_::String_", true);
  auto* graph =
      node.reader("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", true);
  for (auto* reader : {joints, sensor, description, graph})
    EXPECT_TRUE(wait([&] { return RmwNode::take(*reader).has_value(); }))
        << reader->get_topicdescription()->get_name();
  RmwNode::Caller hold(node, "/polyarm/hold", "std_srvs::srv::dds_::Trigger_Request_",
                       "std_srvs::srv::dds_::Trigger_Response_");
  ASSERT_TRUE(wait([&] { return hold.ready(); }));
  for (int i = 0; i < 20; ++i) {
    hold.ask(Bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{0}});
    std::optional<Bytes> answer;
    ASSERT_TRUE(wait([&] { return (answer = hold.answer()).has_value(); })) << i;
    ASSERT_GT(answer->size(), 4u);
    EXPECT_EQ((*answer)[4], std::byte{1}) << "it is held";
  }
}
#endif

#ifdef POLYARM_CYCLONE
const char* const kRover = R"(<robot name="rover">
  <link name="base_link"/><link name="left"/><link name="right"/><link name="upper"/><link name="lower"/>
  <joint name="left_wheel" type="continuous"><parent link="base_link"/><child link="left"/><axis xyz="0 1 0"/><limit velocity="20" effort="1"/></joint>
  <joint name="right_wheel" type="continuous"><parent link="base_link"/><child link="right"/><axis xyz="0 1 0"/><limit velocity="20" effort="1"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
  <ros2_control name="rover" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin><param name="calculate_dynamics">true</param></hardware>
    <joint name="left_wheel"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <joint name="right_wheel"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <joint name="shoulder"><command_interface name="position"/><state_interface name="position"/><state_interface name="velocity"/></joint>
    <joint name="elbow"><command_interface name="position"/><state_interface name="position"/><state_interface name="velocity"/></joint>
  </ros2_control></robot>)";
const char* const kRoverControllers = R"(controller_manager:
  ros__parameters:
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
    forward: {type: forward_command_controller/ForwardCommandController}
    base: {type: diff_drive_controller/DiffDriveController}
arm:
  ros__parameters: {joints: [shoulder, elbow], command_interfaces: [position], state_interfaces: [position, velocity]}
forward:
  ros__parameters: {joints: [shoulder, elbow], interface_name: position}
base:
  ros__parameters: {left_wheel_names: [left_wheel], right_wheel_names: [right_wheel], wheel_separation: 0.4, wheel_radius: 0.1}
)";

using Send = test::CycloneCaller<control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request_,
                                 control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response_>;
using Result = test::CycloneCaller<control_msgs_action_dds__FollowJointTrajectory_GetResult_Request_,
                                   control_msgs_action_dds__FollowJointTrajectory_GetResult_Response_>;
using Switch = test::CycloneCaller<controller_manager_msgs_srv_dds__SwitchController_Request_,
                                   controller_manager_msgs_srv_dds__SwitchController_Response_>;
using Cancel =
    test::CycloneCaller<action_msgs_srv_dds__CancelGoal_Request_, action_msgs_srv_dds__CancelGoal_Response_>;
using Set = test::CycloneCaller<rcl_interfaces_srv_dds__SetParameters_Request_,
                                rcl_interfaces_srv_dds__SetParameters_Response_>;

/// The rover, a client on Fast DDS and one on Cyclone, which does everything in its own types.
class Rover : public ::testing::Test {
 protected:
  const std::string action = "/arm/follow_joint_trajectory/_action/";

  static json goal(double shoulder, double seconds) {
    return {
        {"trajectory",
         {{"joint_names", {"shoulder", "elbow"}},
          {"points", json::array({{{"positions", {shoulder, -shoulder}}, {"time_from_start", seconds}}})}}}};
  }
  bool send_by_fast(int number, const json& goal) {
    return cell.call(action + "send_goal", kType + "_SendGoal",
                     {{"goal_id", id(number)}, {"goal", goal}})["accepted"];
  }
  int result_by_fast(int number) {
    return cell.call(action + "get_result", kType + "_GetResult", {{"goal_id", id(number)}})["status"];
  }
  void set_id(unsigned char (&uuid)[16], int number) {
    std::fill(std::begin(uuid), std::end(uuid), 7);
    uuid[15] = static_cast<unsigned char>(number);
  }
  bool send_by_cyclone(int number, double shoulder, int seconds) {
    const char* names[] = {"shoulder", "elbow"};
    double there[] = {shoulder, -shoulder};
    control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request_ request{};
    set_id(request.uuid, number);
    request.trajectory.header.frame_id = request.multi_dof_trajectory.header.frame_id = nothing.data();
    request.trajectory.joint_names._buffer = const_cast<char**>(names);
    request.trajectory.joint_names._length = request.trajectory.joint_names._maximum = 2;
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ point{};
    point.positions._buffer = there;
    point.positions._length = point.positions._maximum = 2;
    point.time_from_start.sec = seconds;
    request.trajectory.points._buffer = &point;
    request.trajectory.points._length = request.trajectory.points._maximum = 1;
    send.ask(request);
    bool accepted = false;
    EXPECT_TRUE(wait([&] { return send.answered([&](const auto& reply) { accepted = reply.accepted; }); }));
    return accepted;
  }
  int result_by_cyclone(int number) {
    control_msgs_action_dds__FollowJointTrajectory_GetResult_Request_ request{};
    set_id(request.uuid, number);
    result.ask(request);
    int status = -1;
    EXPECT_TRUE(wait([&] { return result.answered([&](const auto& reply) { status = reply.status; }); }));
    return status;
  }
  std::size_t cancel_all_by_cyclone() {
    cancel.ask({});
    std::size_t count = 0;
    EXPECT_TRUE(wait(
        [&] { return cancel.answered([&](const auto& reply) { count = reply.goals_canceling._length; }); }));
    return count;
  }
  bool switch_by_cyclone(const char* on, const char* off) {
    controller_manager_msgs_srv_dds__SwitchController_Request_ request{};
    char *begin[] = {const_cast<char*>(on)}, *end[] = {const_cast<char*>(off)};
    request.activate_controllers._buffer = begin;
    request.deactivate_controllers._buffer = end;
    for (auto* list : {&request.activate_controllers, &request.deactivate_controllers})
      list->_length = list->_maximum = 1;
    request.strictness = 2;
    change.ask(request);
    bool ok = false;
    EXPECT_TRUE(wait([&] { return change.answered([&](const auto& reply) { ok = reply.ok; }); }));
    return ok;
  }
  bool set_goal_time_by_cyclone(double value) {
    std::string name = "constraints.goal_time";
    rcl_interfaces_msg_dds__Parameter_ parameter{};
    parameter.name = name.data();
    parameter.value.type = 3;
    parameter.value.double_value = value;
    parameter.value.string_value = nothing.data();
    rcl_interfaces_srv_dds__SetParameters_Request_ request{};
    request.parameters._buffer = &parameter;
    request.parameters._length = request.parameters._maximum = 1;
    set.ask(request);
    bool done = false;
    EXPECT_TRUE(wait([&] {
      return set.answered([&](const auto& reply) {
        done = reply.results._length == 1 && reply.results._buffer[0].successful;
      });
    }));
    return done;
  }
  std::string state_of(const std::string& name) {
    const json all = cell.call("/controller_manager/list_controllers", kManager + "ListControllers");
    for (const json& c : all["controller"])
      if (c["name"] == name) return c["state"];
    return "";
  }

  /// Node, and how many readers and writers it has.
  using Graph = std::set<std::tuple<std::string, std::size_t, std::size_t>>;
  Graph graph_of_cyclone() {
    Graph out;
    test::take<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(graph, [&](const auto& info) {
      out.clear();
      for (std::uint32_t i = 0; i < info.node_entities_info_seq._length; ++i) {
        const auto& node = info.node_entities_info_seq._buffer[i];
        out.insert({std::string(node.node_namespace) + node.node_name, node.reader_gid_seq._length,
                    node.writer_gid_seq._length});
      }
    });
    return out;
  }
  std::string nothing;
  test::OwnCell cell{
      {{"cell.yaml",
        "polyarm: cell/1\nrate: 200\nrobots:\n  rover: {model: rover.urdf, hardware: declared}\n"
        "controllers: controllers.yaml\nactivate: [joint_state_broadcaster, arm, base]\n"},
       {"rover.urdf", kRover},
       {"controllers.yaml", kRoverControllers}}};
  const test::Cyclone cyclone{cell.domain};
  Send send{cyclone, action + "send_goal",
            control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request__desc,
            control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response__desc};
  Result result{cyclone, action + "get_result",
                control_msgs_action_dds__FollowJointTrajectory_GetResult_Request__desc,
                control_msgs_action_dds__FollowJointTrajectory_GetResult_Response__desc};
  Switch change{cyclone, "/controller_manager/switch_controller",
                controller_manager_msgs_srv_dds__SwitchController_Request__desc,
                controller_manager_msgs_srv_dds__SwitchController_Response__desc};
  Cancel cancel{cyclone, action + "cancel_goal", action_msgs_srv_dds__CancelGoal_Request__desc,
                action_msgs_srv_dds__CancelGoal_Response__desc};
  Set set{cyclone, "/arm/set_parameters", rcl_interfaces_srv_dds__SetParameters_Request__desc,
          rcl_interfaces_srv_dds__SetParameters_Response__desc};
  const dds_entity_t twists = cyclone.writer(geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel");
  const dds_entity_t joints = cyclone.reader(sensor_msgs_msg_dds__JointState__desc, "rt/joint_states");
  const dds_entity_t graph =
      cyclone.reader(rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, "ros_discovery_info", true);
};

TEST_F(Rover, ClientsOfBothMiddlewaresWorkOnItAtOnceAndSeeTheSame) {
  const auto states = cell.client->listen("/joint_states", "sensor_msgs/JointState");
  const auto odometry = cell.client->listen("/odom", "nav_msgs/Odometry");
  const auto stamped = cell.client->publish("/base/cmd_vel", "geometry_msgs/TwistStamped");
  ASSERT_TRUE(wait([&] {
    return send.ready() && result.ready() && change.ready() && cancel.ready() && set.ready() &&
           states->heard() && odometry->heard() && stamped->matched();
  }));
  const auto speed = [&] { return odometry->latest()["twist"]["twist"]["linear"]["x"].get<double>(); };

  // One moves the arm while the other drives, and the other way round.
  ASSERT_TRUE(send_by_cyclone(1, 1.0, 20));
  EXPECT_TRUE(wait([&] {
    stamped->publish({{"twist", {{"linear", {{"x", 0.3}}}}}});
    return speed() > 0.2;
  })) << odometry->latest();
  ASSERT_TRUE(send_by_fast(2, goal(0.5, 20))) << "it takes the place of the other's";
  EXPECT_EQ(result_by_cyclone(1), 6) << "aborted";
  EXPECT_TRUE(wait([&] {
    geometry_msgs_msg_dds__Twist_ twist{};
    twist.linear.x = -0.3;
    dds_write(twists, &twist);
    return speed() < -0.2;
  })) << odometry->latest();

  // What one has begun, the other ends; what one sets, the other reads.
  EXPECT_EQ(cancel_all_by_cyclone(), 1u);
  EXPECT_EQ(result_by_fast(2), 5) << "canceled";
  ASSERT_TRUE(send_by_cyclone(3, 0.4, 20));
  EXPECT_EQ(cell.call(action + "cancel_goal", "action_msgs/srv/CancelGoal",
                      {{"goal_info", {{"goal_id", id(3)}}}})["return_code"],
            0);
  EXPECT_EQ(result_by_cyclone(3), 5);
  EXPECT_TRUE(set_goal_time_by_cyclone(1.25));
  EXPECT_EQ(cell.call("/arm/get_parameters", kParameters + "GetParameters",
                      {{"names", {"constraints.goal_time"}}})["values"][0]["double_value"],
            1.25);
  EXPECT_TRUE(switch_by_cyclone("forward", "arm"));
  EXPECT_EQ(state_of("forward"), "active");
  EXPECT_TRUE(cell.call(
      "/controller_manager/switch_controller", kManager + "SwitchController",
      {{"activate_controllers", {"arm"}}, {"deactivate_controllers", {"forward"}}, {"strictness", 2}})["ok"]);
  EXPECT_FALSE(switch_by_cyclone("arm", "forward")) << "done already, by the other";
  ASSERT_TRUE(send_by_fast(4, goal(0.2, 0.5)));
  EXPECT_EQ(result_by_cyclone(4), 4) << "succeeded, whoever asks";

  // The same state.
  EXPECT_TRUE(wait([&] { return std::abs(speed()) < 1e-6; }));
  std::vector<double> seen;
  EXPECT_TRUE(wait([&] {
    test::take<sensor_msgs_msg_dds__JointState_>(joints, [&](const auto& state) {
      seen.assign(state.position._buffer, state.position._buffer + state.position._length);
    });
    return !seen.empty() && json(seen) == states->latest()["position"];
  })) << json(seen)
      << states->latest();
}

TEST_F(Rover, ClientsOfBothMiddlewaresSeeTheSameGraph) {
  std::mutex mutex;
  Graph of_fast;
  const auto& type = *messages::find_type("rmw_dds_common/msg/ParticipantEntitiesInfo");
  Participant& wire = cell.client->participant();
  const auto reader =
      wire.add_reader("ros_discovery_info", type.dds_name, {true, true, 1}, "", [&](const Sample& sample) {
        json info;
        if (messages::to_json(type, sample.payload, info) != messages::CdrError::none) return;
        const std::lock_guard lock(mutex);
        of_fast.clear();
        for (const json& node : info["node_entities_info_seq"])
          of_fast.insert({node["node_namespace"].get<std::string>() + node["node_name"].get<std::string>(),
                          node["reader_gid_seq"].size(), node["writer_gid_seq"].size()});
      });
  Graph of_cyclone;
  EXPECT_TRUE(wait([&] {
    if (Graph now = graph_of_cyclone(); !now.empty()) of_cyclone = std::move(now);
    const std::lock_guard lock(mutex);
    return of_cyclone.size() == 7 && of_cyclone == of_fast;
  }));
  wire.remove(reader);
  std::set<std::string> nodes;
  for (const auto& [name, readers, writers] : of_cyclone) {
    nodes.insert(name);
    EXPECT_GE(readers, 6u) << name << ": of its parameters' services";
    EXPECT_GE(writers, 6u) << name;
  }
  EXPECT_EQ(nodes, (std::set<std::string>{"/arm", "/base", "/controller_manager", "/forward",
                                          "/joint_state_broadcaster", "/polyarm", "/robot_state_publisher"}));
}
#endif

}  // namespace
}  // namespace polyarm::ros2
