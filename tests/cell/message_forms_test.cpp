#include "polyarm/ros_files/message_forms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using ros_files::message_json;
using ros_files::read_message;
using test::Json;

constexpr const char* kTrajectory = "trajectory_msgs/JointTrajectory";
constexpr const char* kGoal = "control_msgs/FollowJointTrajectory";

template <typename T>
T read(const std::string& text, const std::string& type) {
  return std::get<T>(ros_files::read_message(text, "m.yaml", {type}));
}

/// The sentence with which the message is refused.
std::string refusal(const std::string& text, const std::string& type) {
  try {
    ros_files::read_message(text, "m.yaml", {type});
  } catch (const Error& e) {
    return e.what();
  }
  return "taken";
}

TEST(MessageForms, ATrajectoryOfRos2) {
  const auto m = read<controllers::TrajectoryMessage>(R"(
header: {stamp: {sec: 2, nanosec: 500000000}, frame_id: ""}
joint_names: [a, b]
points:
  - positions: [1.0, 2]
    velocities: [0.1, 0.2]
    accelerations: [0.01, 0.02]
    effort: [5, 6]
    time_from_start: {sec: 1, nanosec: 250000000}
  - {positions: [3, 4], time_from_start: 2.5}
)",
                                                      kTrajectory);
  EXPECT_EQ(m.start, 2'500'000'000);
  EXPECT_EQ(m.joints, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(m.points.size(), 2u);
  EXPECT_EQ(m.points[0].positions, (std::vector<double>{1, 2}));
  EXPECT_EQ(m.points[0].velocities, (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(m.points[0].accelerations, (std::vector<double>{0.01, 0.02}));
  EXPECT_EQ(m.points[0].effort, (std::vector<double>{5, 6}));
  EXPECT_DOUBLE_EQ(m.points[0].time_from_start, 1.25);
  EXPECT_DOUBLE_EQ(m.points[1].time_from_start, 2.5);
}

TEST(MessageForms, ATrajectoryOfRos1AndInJson) {
  const auto one = read<controllers::TrajectoryMessage>(R"(
header: {seq: 1, stamp: {secs: 0, nsecs: 0}, frame_id: ''}
joint_names: [a]
points:
- positions: [1]
  velocities: []
  accelerations: []
  effort: []
  time_from_start: {secs: 3, nsecs: 500000000}
)",
                                                        kTrajectory);
  EXPECT_FALSE(one.start) << "a stamp of zero is now";
  EXPECT_DOUBLE_EQ(one.points[0].time_from_start, 3.5);
  const auto json = read<controllers::TrajectoryMessage>(
      R"({"joint_names":["a"],"points":[{"positions":[1e-1],"time_from_start":{"sec":1,"nanosec":0}}]})",
      kTrajectory);
  EXPECT_DOUBLE_EQ(json.points[0].positions[0], 0.1);
  EXPECT_DOUBLE_EQ(json.points[0].time_from_start, 1);
}

TEST(MessageForms, AGoalWithTolerancesWithAndWithoutItsOuterKey) {
  const std::string inner = R"(
trajectory: {joint_names: [a], points: [{positions: [1], time_from_start: 1}]}
path_tolerance: [{name: a, position: 0.1, velocity: -1}]
goal_tolerance: [{name: a, position: 0.02, acceleration: 0.5}]
goal_time_tolerance: {sec: 0, nanosec: 500000000}
)";
  std::string outer = "goal:";
  for (const char c : inner) outer += c == '\n' ? std::string("\n  ") : std::string(1, c);
  for (const std::string& text : {inner, outer}) {
    const auto m = read<controllers::TrajectoryMessage>(text, kGoal);
    EXPECT_EQ(m.joints.size(), 1u);
    ASSERT_EQ(m.path_tolerance.size(), 1u);
    EXPECT_EQ(m.path_tolerance[0].position, 0.1);
    EXPECT_EQ(m.path_tolerance[0].velocity, -1);
    EXPECT_EQ(m.goal_tolerance[0].acceleration, 0.5);
    EXPECT_DOUBLE_EQ(m.goal_time_tolerance.value(), 0.5);
  }
  EXPECT_EQ(read<controllers::TrajectoryMessage>(
                "{joint_names: [a], points: [{positions: [1], time_from_start: 1}]}", kGoal)
                .points.size(),
            1u);
}

TEST(MessageForms, Twists) {
  const auto plain =
      read<controllers::Twist>("{linear: {x: 0.5, y: 0, z: 0}, angular: {z: -1}}", "geometry_msgs/Twist");
  EXPECT_EQ(plain.linear.x, 0.5);
  EXPECT_EQ(plain.angular.z, -1);
  EXPECT_FALSE(plain.stamp);
  const auto stamped = read<controllers::Twist>(
      "{header: {stamp: {sec: 1, nanosec: 5}, frame_id: base}, twist: {linear: {x: 0.25}}}",
      "geometry_msgs/TwistStamped");
  EXPECT_EQ(stamped.linear.x, 0.25);
  EXPECT_EQ(stamped.stamp, 1'000'000'005);
  EXPECT_EQ(read<controllers::Twist>("{twist: {angular: {z: 2}}}", "geometry_msgs/TwistStamped").stamp, 0);
}

TEST(MessageForms, NumbersInAllTheirForms) {
  const auto numbers = [](const std::string& text, const char* type) {
    return read<controllers::Numbers>(text, type).values;
  };
  EXPECT_EQ(numbers("{layout: {dim: [], data_offset: 0}, data: [1, 2.5]}", "std_msgs/Float64MultiArray"),
            (std::vector<double>{1, 2.5}));
  EXPECT_EQ(numbers("data: 3", "std_msgs/Float64"), std::vector<double>{3});
  EXPECT_EQ(numbers("[1, 2]", "std_msgs/Float64MultiArray"), (std::vector<double>{1, 2}));
  EXPECT_EQ(numbers("7", "std_msgs/Float64"), std::vector<double>{7});
  EXPECT_EQ(numbers("factor: 0.5", "control_msgs/SpeedScalingFactor"), std::vector<double>{0.5});
  EXPECT_EQ(numbers("{x: 1, yaw: 0.5}", "control_msgs/SetOdometry"), (std::vector<double>{1, 0, 0.5}));
}

TEST(MessageForms, NamedValuesInAllTheirForms) {
  const auto dynamic = read<controllers::NamedValues>(
      "{joint_names: [a, b], interface_values: [{interface_names: [p, v], values: [1, 2]}, {interface_names: "
      "[p], values: [3]}]}",
      "control_msgs/DynamicJointState");
  EXPECT_EQ(dynamic.names, (std::vector<std::string>{"a/p", "a/v", "b/p"}));
  EXPECT_EQ(dynamic.values, (std::vector<double>{1, 2, 3}));
  const auto dofs = read<controllers::NamedValues>("{dof_names: [a, b], values: [1, 2], values_dot: [3, 4]}",
                                                   "control_msgs/MultiDOFCommand");
  EXPECT_EQ(dofs.names, (std::vector<std::string>{"a", "b", "a/dot", "b/dot"}));
  EXPECT_EQ(read<controllers::NamedValues>("{a/p: 1}", "control_msgs/DynamicJointState").values,
            std::vector<double>{1});
}

TEST(MessageForms, AWrenchWithItsFrameAndOnePoint) {
  using controllers::NamedValues;
  const auto wrench =
      read<NamedValues>("{header: {frame_id: tool0}, wrench: {force: {z: -6}, torque: {x: 0.5}}}",
                        "geometry_msgs/WrenchStamped");
  ASSERT_EQ(wrench.names.size(), 7u);
  EXPECT_EQ(wrench.names[2], "force.z");
  EXPECT_EQ(wrench.values[2], -6);
  EXPECT_EQ(wrench.values[3], 0.5);
  EXPECT_EQ(wrench.names[6], "frame_id=tool0");
  EXPECT_EQ(read<NamedValues>("{force: {x: 1}}", "geometry_msgs/WrenchStamped").names.size(), 6u);
  const auto point = read<controllers::TrajectoryMessage>("{positions: [1, 2], velocities: [3, 4]}",
                                                          "trajectory_msgs/JointTrajectoryPoint");
  ASSERT_EQ(point.points.size(), 1u);
  EXPECT_EQ(point.points[0].velocities, (std::vector<double>{3, 4}));
  const auto place =
      read<controllers::Numbers>("{x: 1, y: 2, z: 0, roll: 0, pitch: 0, yaw: 3}", "control_msgs/SetOdometry");
  EXPECT_EQ(place.values, (std::vector<double>{1, 2, 3}));
}

TEST(MessageForms, AListOfMessagesComesOutAsOne) {
  controllers::Output batteries("raw_battery_states", "control_msgs/BatteryStateArray",
                                {"battery_states[0].voltage", "battery_states[1].voltage"});
  batteries.draft().values = {24, 25};
  batteries.publish(0);
  batteries.fetch();
  EXPECT_EQ(Json::parse(ros_files::message_json(batteries))["battery_states"],
            Json::parse(R"([{"voltage": 24}, {"voltage": 25}])"));
}

TEST(MessageForms, GripperCommands) {
  const auto old = read<controllers::GripperCommand>("{command: {position: 0.04, max_effort: 5}}",
                                                     "control_msgs/GripperCommand");
  EXPECT_EQ(old.position, 0.04);
  EXPECT_EQ(old.max_effort, 5);
  EXPECT_FALSE(old.max_velocity);
  const auto parallel = read<controllers::GripperCommand>(
      "goal: {command: {name: [f], position: [0.02], velocity: [0.1], effort: []}}",
      "control_msgs/ParallelGripperCommand");
  EXPECT_EQ(parallel.position, 0.02);
  EXPECT_EQ(parallel.max_velocity, 0.1);
  EXPECT_FALSE(parallel.max_effort);
}

TEST(MessageForms, RefusalsSayWhichKeyAndWhere) {
  const auto says = [](const std::string& text, const std::string& type, const std::string& wanted) {
    const std::string why = refusal(text, type);
    EXPECT_NE(why.find(wanted), std::string::npos) << text << "\n" << why;
  };
  says("{joint_names: [a], pionts: []}", kTrajectory, "did you mean 'points'");
  says("joint_names: [a]\npoints:\n - position: [1]\n   time_from_start: 1", kTrajectory, "m.yaml:3");
  says("joint_names: [a]\npoints:\n - positions: [1]", kTrajectory, "no time_from_start");
  says("joint_names: [a]\npoints:\n - positions: [one]\n   time_from_start: 1", kTrajectory,
       "m.yaml:3:16: error: positions of point 1, a: 'one'");
  says("{joint_names: [a], points: [{positions: [1], time_from_start: {seconds: 1}}]}", kTrajectory,
       "'seconds' is not known");
  says("{joint_names: [a]}", kTrajectory, "no points");
  says("{points: []}", kTrajectory, "joint_names");
  says("5", kTrajectory, "not a trajectory");
  says("", kTrajectory, "not a trajectory");
  says("{joint_names: [a], points: [1, 2]}", kTrajectory, "not a point");
  says("{trajectory: {joint_names: [a], points: []}}", kTrajectory, "--goal");
  says("{trajectory: {joint_names: [a], points: []}, path_tolerance: [{nam: a}]}", kGoal,
       "did you mean 'name'");
  says("{trajectory: {joint_names: [a], points: []}, path_tolerance: [0.1]}", kGoal, "not a tolerance");
  says("{}", kGoal, "trajectory");
  says("{header: {stamp: -4}, joint_names: [a], points: []}", kTrajectory, "not a time");
  says("{linaer: {x: 1}}", "geometry_msgs/Twist", "did you mean 'linear'");
  says("{}", "geometry_msgs/Twist", "neither linear nor angular");
  says("{linear: {w: 1}}", "geometry_msgs/Twist", "'w' is not known");
  says("{data: [1, x]}", "std_msgs/Float64MultiArray", "'x'");
  says("{values: [1]}", "std_msgs/Float64MultiArray", "not known");
  says("{}", "std_msgs/Float64", "no data");
  says("{joint_names: [a], interface_values: []}", "control_msgs/DynamicJointState",
       "1 joint_names do not match 0");
  says("{dof_names: [a], values: [1, 2]}", "control_msgs/MultiDOFCommand",
       "1 dof_names do not match 2 values");
  says("3", "control_msgs/DynamicJointState", "not a message of named values");
  says("{force_: {x: 1}}", "geometry_msgs/WrenchStamped", "force_");
  says("{header: {}}", "geometry_msgs/WrenchStamped", "neither force nor torque");
  says("{}", "trajectory_msgs/JointTrajectoryPoint", "no positions");
  says("{max_effort: 1}", "control_msgs/GripperCommand", "position");
  says("{a: [}", kTrajectory, "not valid YAML");
  says(std::string(100'000, '['), kTrajectory, "nested");
}

TEST(MessageForms, WhatComesOutHasTheShapeOfRos) {
  controllers::Output odom("odom", "nav_msgs/Odometry",
                           {"pose.pose.position.x", "twist.twist.angular.z", "pose.covariance[7]"});
  odom.texts = {{"frame_id", "odom"}, {"child_frame_id", "base_link"}};
  odom.draft().values = {1.5, NAN, 0.25};
  odom.publish(2'000'000'003);
  ASSERT_TRUE(odom.fetch());
  EXPECT_EQ(Json::parse(ros_files::message_json(odom)), Json::parse(R"({
    "header": {"stamp": {"sec": 2, "nanosec": 3}, "frame_id": "odom"}, "child_frame_id": "base_link",
    "pose": {"pose": {"position": {"x": 1.5}}, "covariance": [0, 0, 0, 0, 0, 0, 0, 0.25]},
    "twist": {"twist": {"angular": {"z": null}}}})"));

  controllers::Output joints(
      "joint_states", "sensor_msgs/JointState",
      {"a/position", "a/velocity", "a/effort", "b.c/position", "b.c/velocity", "b.c/effort"});
  joints.draft().values = {1, 2, NAN, 4, INFINITY, 6};
  joints.publish(0);
  joints.fetch();
  const Json state = Json::parse(ros_files::message_json(joints));
  EXPECT_EQ(state["name"], Json({"a", "b.c"}));
  EXPECT_EQ(state["position"], Json({1.0, 4.0}));
  EXPECT_EQ(state["velocity"], Json({2.0, nullptr}));
  EXPECT_EQ(state["effort"], Json({nullptr, 6.0}));

  controllers::Output dynamic("gpio_states", "control_msgs/DynamicJointState", {"a/p", "b/p", "a/v"});
  dynamic.draft().values = {1, 2, 3};
  dynamic.publish(0);
  dynamic.fetch();
  const Json groups = Json::parse(ros_files::message_json(dynamic));
  EXPECT_EQ(groups["joint_names"], Json({"a", "b"}));
  EXPECT_EQ(groups["interface_values"][0], Json({{"interface_names", {"p", "v"}}, {"values", {1.0, 3.0}}}));

  controllers::Output values("values", "control_msgs/Float64Values", {"a/p"});
  values.draft().values = {1};
  values.publish(0);
  values.fetch();
  EXPECT_EQ(Json::parse(ros_files::message_json(values))["names"], Json({"a/p"}));
  EXPECT_EQ(Json::parse(ros_files::message_json(values))["values"], Json({1.0}));
}

TEST(MessageForms, TheStateOfATrajectoryControllerHasAListForEachQuantity) {
  controllers::Output out("controller_state", "control_msgs/JointTrajectoryControllerState",
                          {"a.b.reference.position", "a.b.error.position", "a.b.output",
                           "c.reference.position", "c.error.position", "c.output", "time_from_start"});
  out.draft().values = {1, 2, 3, 4, 5, 6, 7};
  out.publish(0);
  out.fetch();
  const Json state = Json::parse(ros_files::message_json(out));
  EXPECT_EQ(state["joint_names"], Json({"a.b", "c"}));
  EXPECT_EQ(state["reference"]["positions"], Json({1.0, 4.0}));
  EXPECT_EQ(state["error"]["positions"], Json({2.0, 5.0}));
  EXPECT_EQ(state["output"], Json({3.0, 6.0}));
  EXPECT_EQ(state["reference"]["time_from_start"], 7.0);
}

const std::vector<std::string>& seeds() {
  static const std::vector<std::string> texts = {
      "{joint_names: [joint_1, joint_2], points: [{positions: [0.1, 0.2], velocities: [0, 0], accelerations: "
      "[0, 0], "
      "time_from_start: {sec: 1, nanosec: 5}}, {positions: [0.2, 0.1], time_from_start: 2.5}]}",
      "goal:\n  trajectory:\n    header: {stamp: {secs: 1, nsecs: 2}}\n    joint_names: [joint_1, joint_2]\n "
      "   points:\n    - "
      "positions: [1, 2]\n      time_from_start: 1\n  path_tolerance: [{name: joint_1, position: 0.1}]\n  "
      "goal_time_tolerance: 1\n",
      "{header: {stamp: {sec: 1}}, twist: {linear: {x: 1}, angular: {z: 2}}}",
      "{layout: {}, data: [1, 2.5, -3e-4]}",
      "{joint_names: [a, b], interface_values: [{interface_names: [p], values: [1]}, {interface_names: [], "
      "values: []}]}",
      "{dof_names: [a], values: [1], values_dot: [2]}",
      "{command: {position: 0.04, max_effort: 5}}",
      "{command: {name: [f], position: [0.02], velocity: [0.1]}}",
      "{x: 1, y: 2, yaw: 3}",
  };
  return texts;
}

std::string mutated(std::string text, std::mt19937& random) {
  static const std::vector<std::string> pieces = {
      "[",    "]",    "{",    "}",  ": ",   "- ",   "1e309", "-1e308", ".nan", ".inf",
      "null", "&a ",  "*a",   "\n", "\t",   "!!x ", "\"",    "'",      "|",    "%",
      "~",    "0x7f", "9e15", "-0", "\xff", "? ",   "<<: ",  "---\n",  "#",    "1_0"};
  for (unsigned n = 1 + random() % 4; n > 0 && !text.empty(); --n) {
    const std::size_t at = random() % text.size(),
                      length = random() % std::min<std::size_t>(12, text.size() - at + 1);
    switch (random() % 4) {
      case 0:
        text[at] = static_cast<char>(random() % 256);
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, pieces[random() % pieces.size()]);
        break;
      default:
        text.insert(random() % text.size(), text.substr(at, length));
        break;
    }
  }
  return text;
}

TEST(MessageForms, MutatedMessagesAreReadOrRefusedWithASentence) {
  std::mt19937 random(3);
  int taken = 0, refused = 0;
  for (int n = 0; n < 20'000; ++n) {
    const std::string text = mutated(seeds()[random() % seeds().size()], random);
    const std::string type = ros_files::message_types()[random() % ros_files::message_types().size()];
    try {
      ros_files::read_message(text, "m", {type});
      ++taken;
    } catch (const Error& e) {
      ++refused;
      EXPECT_FALSE(std::string(e.what()).empty());
    }
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 1000);
}

TEST(MessageForms, WhateverIsSentTheArmStaysWithinItsLimits) {
  test::LockStepCell cell(R"(
controller_manager:
  ros__parameters:
    update_rate: 500
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
follow:
  ros__parameters: {joints: [joint_1, joint_2], command_interfaces: [position], state_interfaces: [position, velocity]}
)");
  std::mt19937 random(4);
  for (int n = 0; n < 1500; ++n) {
    cell.give(Json{{"request", "send"},
                   {"to", random() % 2 ? "follow/joint_trajectory" : "follow/follow_joint_trajectory"},
                   {"message", mutated(seeds()[random() % 2], random)}});
    for (int i = 0; i < 5; ++i) cell.tick();
    for (const char* joint : {"arm/joint_1/position", "arm/joint_2/position"}) {
      const double at = cell.value_of("states", joint);
      ASSERT_TRUE(at >= -3.1416 && at <= 3.1416) << joint << " " << at;
    }
  }
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
}

}  // namespace
}  // namespace polyarm
