#include <gtest/gtest.h>

#include "tests/ros_files/controllers_texts.hpp"

namespace polyarm::ros_files::controllers_texts {
namespace {

TEST(Ros1Controllers, MyRobotIsRead) {
  const auto [file, problems] = read(kMyRobot);
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(file.controllers.size(), 4u);
  EXPECT_EQ(file.controllers[0].full_name(), "/MyRobot/joint_state_controller");
  EXPECT_EQ(file.controllers[0].parameters.number("publish_rate", 0), 50);
  const ControllerEntry& a = file.controllers[1];
  EXPECT_EQ(a.full_name(), "/MyRobot/JointA_EffortController");
  EXPECT_EQ(a.type, "effort_controllers/JointEffortController");
  EXPECT_TRUE(a.ros1);
  EXPECT_EQ(text_of(a, "joint"), "JointA");
  EXPECT_EQ(a.parameters.number("pid.p", 0), 100);
  EXPECT_EQ(a.parameters.number("pid.i", 0), 10);
  EXPECT_EQ(a.parameters.number("pid.d", 0), 1);
  EXPECT_EQ(a.parameters.entries.at("pid.p").where.line, 9);
  EXPECT_EQ(text_of(file.controllers[3], "joint"), "JointC");
}

TEST(Ros1Controllers, LimitsAreFoundAtAnyDepthForTheirReader) {
  for (const char* text :
       {"MyRobot:\n  joint_limits:\n    JointA:\n      has_position_limits: true\n"
        "      min_position: -1.57\n      max_position: 3.14\n      has_velocity_limits: true\n"
        "      max_velocity: 1.5\n",
        "joint_limits: {JointC: {has_velocity_limits: false, max_velocity: 0}}\n",
        "/**:\n  ros__parameters:\n    planning: {joint_limits: {a: {max_velocity: 1.5}}}\n"}) {
    const auto [file, problems] = read(text);
    EXPECT_EQ(all(problems), "");
    ASSERT_EQ(file.joint_limits.size(), 1u) << text;
    EXPECT_EQ(file.joint_limits[0].keys.back(), "joint_limits");
    EXPECT_TRUE(file.controllers.empty());
    EXPECT_TRUE(file.unused.empty()) << file.unused[0].key;
  }
  const JointLimitsSource limits =
      read("MyRobot:\n  joint_limits: {a: {max_velocity: 1.5}}\n").file.joint_limits.at(0);
  EXPECT_EQ(limits.keys, (std::vector<std::string>{"MyRobot", "joint_limits"}));
  EXPECT_EQ(limits.ns, "/MyRobot");
  EXPECT_EQ(limits.where.text(), "c.yaml:2:3");
  Problems problems;
  const ControllersFile whole =
      read_controllers({{"c.yaml", "/MyRobot/joint_limits", "a: {max_velocity: 1.5}"}}, problems);
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(whole.joint_limits.size(), 1u);
  EXPECT_TRUE(whole.joint_limits[0].keys.empty());
  EXPECT_EQ(whole.joint_limits[0].ns, "/MyRobot");
}

TEST(Ros1Controllers, SeveralNamespacesAndNoneStandSideBySide) {
  const auto [file, problems] =
      read(R"(left: {arm: {jtc: {type: position_controllers/JointTrajectoryController, joints: [a, b]}}}
/right/jtc: {type: effort_controllers/JointTrajectoryController, joints: [c], gains: {c: {p: 1, i: 2, d: 3, i_clamp: 4}}}
gripper_controller: {type: position_controllers/JointPositionController, joint: g}
jtc/constraints/goal_time: 0.5
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(text_of(find(file, "/left/arm/jtc"), "joints"), "a,b");
  EXPECT_EQ(find(file, "/right/jtc").parameters.number("gains.c.i_clamp", 0), 4);
  EXPECT_EQ(find(file, "/gripper_controller").ns, "/");
}

TEST(Ros1Controllers, GainsOfGazeboAndTheLoopRateAreKept) {
  const auto [file, problems] = read(R"(/gazebo_ros_control:
  pid_gains:
    elbow: {p: 100.0, i: 0.01, d: 10.0}
hardware_control_loop: {loop_hz: 125}
arm_controller: {type: velocity_controllers/JointTrajectoryController, joints: [elbow]}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.pid_gains.number("elbow.p", 0), 100);
  EXPECT_EQ(file.update_rate, 125);
  EXPECT_EQ(file.controllers.size(), 1u);
}

TEST(Ros1Controllers, OldKeysAreTheirOwnAndNoCauseForWarnings) {
  const auto [file, problems] = read(R"(drive:
  type: diff_drive_controller/DiffDriveController
  left_wheel: l
  right_wheel: r
  publish_rate: 50
  linear: {x: {has_velocity_limits: false, max_velocity: 0}}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_TRUE(file.controllers.at(0).parameters.has("publish_rate"));
}

TEST(Ros1Controllers, ListsOfMapsKeepTheirNames) {
  const auto [file, problems] = read(R"(states:
  type: joint_state_controller/JointStateController
  extra_joints:
    - {name: wheel, position: 0.5}
    - {position: rad(1.5), velocity: deg(180)}
)");
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& states = file.controllers.at(0);
  EXPECT_EQ(text_of(states, "extra_joints"), "wheel,1");
  EXPECT_EQ(states.parameters.number("extra_joints.wheel.position", 0), 0.5);
  EXPECT_EQ(states.parameters.number("extra_joints.1.position", 0), 1.5);
  EXPECT_NEAR(states.parameters.number("extra_joints.1.velocity", 0), 3.14159265358979, 1e-12);
}

TEST(Ros1Controllers, HardwareAndAPlannersListAreNoControllers) {
  const auto [file, problems] = read(
      "arm_hw: {type: my_robot/MyRobotHW, joints: [a]}\n"
      "hardware_interface: {joints: [a, b]}\n"
      "jtc: {type: a/B}\n");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.controllers.size(), 1u);
  EXPECT_EQ(file.unused.size(), 3u);
}

TEST(Ros1Controllers, SourcesMayStandInANamespaceAndBeOneValue) {
  Problems problems;
  ParameterSource value{"top.launch", "/MyRobot/JointA_EffortController/pid/p", "55"};
  value.literal = true;
  value.where = {"top.launch", 9, 0};
  const ControllersFile file =
      read_controllers({{"a.yaml", "/MyRobot", "JointA_EffortController: {type: a/B, pid: {p: 1}}"},
                        value,
                        {"b.yaml", "/MyRobot/JointA_EffortController/joints", "[x, y]"}},
                       problems);
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& a = find(file, "/MyRobot/JointA_EffortController");
  EXPECT_EQ(a.parameters.number("pid.p", 0), 55);
  EXPECT_EQ(a.parameters.entries.at("pid.p").where.line, 9);
  EXPECT_EQ(text_of(a, "joints"), "x,y");
}

}  // namespace
}  // namespace polyarm::ros_files::controllers_texts
