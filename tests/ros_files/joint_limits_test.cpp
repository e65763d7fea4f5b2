#include "polyarm/ros_files/joint_limits.hpp"

#include <gtest/gtest.h>

namespace polyarm::ros_files {
namespace {

controllers::JointFacts joint(const std::string& name) {
  controllers::JointFacts out{"arm/" + name, false, -3, 3, 2, 8, 80};
  return out;
}

std::string read(const std::string& text, std::vector<controllers::JointFacts>& joints) {
  std::vector<controllers::JointFacts*> all;
  for (auto& j : joints) all.push_back(&j);
  Problems problems;
  narrow_by_file({"joint_limits.yaml", text, {"joint_limits"}, "/", {}}, all, problems);
  std::string told;
  for (const Problem& problem : problems.list()) told += problem.text() + "\n";
  return told;
}

TEST(JointLimitsFile, TheTighterOneHolds) {
  std::vector joints{joint("JointA")};
  EXPECT_EQ(read("joint_limits:\n  JointA:\n    has_position_limits: true\n    min_position: -1.57\n    "
                 "max_position: 9\n"
                 "    has_velocity_limits: true\n    max_velocity: 1.5\n    has_effort_limits: true\n    "
                 "max_effort: 255\n",
                 joints),
            "");
  EXPECT_EQ(joints[0].lower, -1.57);
  EXPECT_EQ(joints[0].upper, 3);
  EXPECT_EQ(joints[0].velocity, 1.5);
  EXPECT_EQ(joints[0].effort, 255);
}

TEST(JointLimitsFile, AFalseFlagWithAZeroDoesNotFreezeTheJoint) {
  std::vector joints{joint("JointC")};
  EXPECT_EQ(read("joint_limits:\n  JointC:\n    has_velocity_limits: false\n    max_velocity: 0\n"
                 "    has_acceleration_limits: false\n    max_acceleration: 0.0\n",
                 joints),
            "");
  EXPECT_EQ(joints[0].velocity, 2);
  EXPECT_FALSE(joints[0].states_acceleration);
}

TEST(JointLimitsFile, AZeroThatCountsIsToldAndPassedOver) {
  std::vector joints{joint("JointC")};
  const std::string told =
      read("joint_limits:\n  JointC:\n    has_velocity_limits: true\n    max_velocity: 0\n", joints);
  EXPECT_NE(told.find("joint_limits.yaml:4"), std::string::npos) << told;
  EXPECT_NE(told.find("freeze"), std::string::npos) << told;
  EXPECT_EQ(joints[0].velocity, 2);
}

TEST(JointLimitsFile, AccelerationsThatAreStatedLimitCommands) {
  std::vector joints{joint("a")};
  read(
      "joint_limits:\n  a: {has_acceleration_limits: true, max_acceleration: 20, has_jerk_limits: true, "
      "max_jerk: 500}\n",
      joints);
  EXPECT_TRUE(joints[0].states_acceleration);
  EXPECT_EQ(joints[0].acceleration, 20) << "what was only assumed gives way";
}

TEST(JointLimitsFile, WrongKeysJointsAndTypesAreTold) {
  std::vector joints{joint("JointA")};
  const std::string told = read(
      "joint_limits:\n  JointA:\n    max_velocty: 3\n    has_position_limits: maybe\n  JointQ:\n    "
      "max_velocity: 1\n",
      joints);
  EXPECT_NE(told.find("max_velocity"), std::string::npos) << told;
  EXPECT_NE(told.find(":4"), std::string::npos) << told;
  EXPECT_NE(told.find("did you mean 'JointA'"), std::string::npos) << told;
}

TEST(JointLimitsFile, SoftLimitsStayWithinTheHardOnes) {
  std::vector joints{joint("JointA")};
  read(
      "joint_limits:\n  JointA: {has_soft_limits: true, k_position: 10, k_velocity: 20, soft_lower_limit: "
      "-9, "
      "soft_upper_limit: 2.5}\n",
      joints);
  ASSERT_TRUE(joints[0].soft);
  EXPECT_EQ(joints[0].soft->lower, -3);
  EXPECT_EQ(joints[0].soft->upper, 2.5);
}

TEST(HardwareLimits, MinAndMaxOfInterfacesNarrowTheDescription) {
  description::RobotModel model;
  description::InterfaceInfo position{"position"}, velocity{"velocity"}, acceleration{"acceleration"};
  position.min = -6.28;
  position.max = 1;
  velocity.min = -3.15;
  velocity.max = 1.5;
  acceleration.max = 5;
  model.hardware.push_back({"h", "system"});
  model.hardware[0].components.push_back({"joint_1", "joint", {position, velocity, acceleration}});
  controllers::JointFacts facts = joint("joint_1");
  Problems problems;
  narrow_by_hardware(model, "joint_1", facts, problems);
  EXPECT_TRUE(problems.list().empty());
  EXPECT_EQ(facts.lower, -3);
  EXPECT_EQ(facts.upper, 1);
  EXPECT_EQ(facts.velocity, 1.5) << "the smaller of both sides";
  EXPECT_EQ(facts.acceleration, 5);
  EXPECT_EQ(facts.deceleration, 5) << "one that is missing is like the other";
}

TEST(HardwareLimits, ARangeBesideThatOfTheJointIsRefusedWithBothAndTheLine) {
  description::RobotModel model;
  description::InterfaceInfo position{"position"};
  position.min = 3.25;
  position.max = 4;
  position.where = {"arm.urdf", 12};
  model.hardware.push_back({"h", "system"});
  model.hardware[0].components.push_back({"joint_1", "joint", {position}});
  controllers::JointFacts facts = joint("joint_1");
  Problems problems;
  narrow_by_hardware(model, "joint_1", facts, problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].code, "bad-limit");
  EXPECT_EQ(problems.list()[0].where.line, 12);
  EXPECT_NE(problems.list()[0].what.find("allows 3.25 to 4, the joint -3 to 3"), std::string::npos)
      << problems.list()[0].what;
  EXPECT_LE(facts.lower, facts.upper) << "what works with the limits goes on";
}

TEST(JointLimitsFile, ARangeBesideThatOfTheJointIsRefusedWithBoth) {
  std::vector joints{joint("JointA")};
  const std::string told = read("joint_limits:\n  JointA: {min_position: 4, max_position: 5}\n", joints);
  EXPECT_NE(told.find("allows 4 to 5, the description -3 to 3"), std::string::npos) << told;
  EXPECT_LE(joints[0].lower, joints[0].upper);
}

}  // namespace
}  // namespace polyarm::ros_files
