/// What of a robot has a body, stands on the floor, or looks like a placeholder.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/description/bodies.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::bodies_test {
namespace {

using description::RobotModel;

RobotModel read(const std::string& inside) {
  Problems problems;
  RobotModel out = description::read_urdf("<robot name='r'>" + inside + "</robot>", "r.urdf", problems);
  EXPECT_FALSE(problems.has_errors());
  return out;
}

std::string wheel(const std::string& name, const std::string& parent, const std::string& xyz) {
  return "<link name='" + name +
         "'><collision><geometry><cylinder radius='0.1' length='0.05'/></geometry></collision></link>"
         "<joint name='" + name + "_joint' type='continuous'><parent link='" + parent + "'/><child link='" + name +
         "'/><origin xyz='" + xyz + "' rpy='1.5708 0 0'/><axis xyz='0 0 1'/></joint>";
}

TEST(Bodies, LinksOfMeshesAloneOrOfNothingButLooksHaveNone) {
  const RobotModel model = read(
      "<link name='base'><collision><geometry><mesh filename='a.stl'/></geometry></collision></link>"
      "<link name='arm'><collision><geometry><box size='1 1 1'/></geometry></collision>"
      "<collision><geometry><mesh filename='a.stl'/></geometry></collision></link>"
      "<link name='hand'><visual><geometry><box size='1 1 1'/></geometry></visual></link>"
      "<link name='tool0'/>"
      "<joint name='a' type='fixed'><parent link='base'/><child link='arm'/></joint>"
      "<joint name='b' type='fixed'><parent link='arm'/><child link='hand'/></joint>"
      "<joint name='c' type='fixed'><parent link='hand'/><child link='tool0'/></joint>");
  EXPECT_EQ(description::links_without_body(model), (std::vector<std::string>{"base", "hand"}));
}

TEST(Bodies, WheelsAndWhatCarriesThemMayTouchTheFloorAnArmMayNot) {
  const RobotModel model = read(
      "<link name='chassis'/><link name='caster'/><link name='steer'/>"
      "<link name='arm'><collision><geometry><box size='1 1 1'/></geometry></collision></link>"
      "<joint name='f' type='fixed'><parent link='chassis'/><child link='caster'/></joint>"
      "<joint name='s' type='revolute'><parent link='chassis'/><child link='steer'/><axis xyz='0 0 1'/>"
      "<limit lower='-1' upper='1' effort='5' velocity='1'/></joint>"
      "<joint name='a' type='revolute'><parent link='chassis'/><child link='arm'/><axis xyz='0 1 0'/>"
      "<limit lower='-1' upper='1' effort='5' velocity='1'/></joint>" +
      wheel("front", "steer", "0.3 0 0") + wheel("left", "chassis", "0 0.2 0") + wheel("right", "chassis", "0 -0.2 0"));
  const auto stands = description::links_on_the_floor(model, false);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    EXPECT_EQ(stands[i] != 0, model.links[i].name != "arm") << model.links[i].name;
}

TEST(Bodies, ArmsHaveNoWheels) {
  const RobotModel model = read("<link name='base'/>" + wheel("wrist", "base", "0 0 1"));
  for (const char stands : description::links_on_the_floor(model, false)) EXPECT_EQ(stands, 0);
  for (const char stands : description::links_on_the_floor(model, true)) EXPECT_EQ(stands, 1);
}

/// Names of the links that may touch the floor.
std::string rolling(const RobotModel& model, const std::vector<std::string>& said) {
  std::vector<int> joints;
  for (const std::string& name : said) joints.push_back(model.find_joint(name));
  std::string out;
  const auto stands = description::links_on_the_floor(model, false, joints);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (stands[i]) out += (out.empty() ? "" : " ") + model.links[i].name;
  return out;
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& axis) {
  return "<link name='" + name +
         "'><collision><geometry><mesh filename='a.stl'/></geometry></collision></link>" + "<joint name='" +
         name + "_joint' type='" + type + "'><parent link='" + parent + "'/><child link='" + name +
         "'/><axis xyz='" + axis + "'/><limit lower='-1' upper='1' effort='5' velocity='1'/></joint>";
}

/// An arm on a base with two wheels, two casters that swivel, one on a spring, and a turret.
std::string mobile_arm(const std::string& wheel) {
  return "<link name='chassis'/>" + wheel + joint("fixed_caster", "fixed", "chassis", "1 0 0") +
         joint("swivel", "continuous", "chassis", "0 0 -1") +
         joint("roller", "continuous", "swivel", "0 1 0") + joint("spring", "prismatic", "chassis", "0 0 1") +
         joint("sprung", "continuous", "spring", "0 1 0") +
         joint("shoulder", "continuous", "chassis", "0 0 1") +
         joint("elbow", "revolute", "shoulder", "0 1 0") + joint("wrist", "continuous", "elbow", "0 1 0");
}

TEST(Bodies, WhatAControllerDrivesIsAWheelWhateverItLooksLike) {
  const std::string
      none =
          "<link name='left'/><joint name='left_joint' type='continuous'><parent link='chassis'/>"
          "<child link='left'/><axis xyz='0 1 0'/></joint>",
      mesh = joint("right", "continuous", "chassis", "0 1 0");
  const RobotModel model = read(mobile_arm(none + mesh));
  EXPECT_EQ(rolling(model, {}), "") << "shapes say nothing";
  EXPECT_EQ(rolling(model, {"left_joint", "right_joint"}), "chassis left right fixed_caster swivel roller");
}

TEST(Bodies, ACasterOnASpringThatNothingCommandsMayTouchTheFloor) {
  std::string commanded = "<ros2_control name='h' type='system'><hardware><plugin>p</plugin></hardware>";
  for (const char* name : {"left", "right", "shoulder", "elbow", "wrist"})
    commanded += "<joint name='" + std::string(name) + "_joint'><command_interface name='velocity'/></joint>";
  const std::string wheels =
      joint("left", "continuous", "chassis", "0 1 0") + joint("right", "continuous", "chassis", "0 1 0");
  const RobotModel model = read(mobile_arm(wheels) + commanded + "</ros2_control>");
  EXPECT_EQ(rolling(model, {"left_joint", "right_joint"}),
            "chassis left right fixed_caster swivel roller spring sprung");
}

TEST(Bodies, WhatASteeringJointCarriesMayTouchTheFloor) {
  const RobotModel model =
      read("<link name='chassis'/>" + joint("knuckle", "revolute", "chassis", "0 0 1") +
           joint("front", "continuous", "knuckle", "0 1 0") +
           joint("rear", "continuous", "chassis", "0 1 0") + joint("lift", "prismatic", "chassis", "0 0 1"));
  EXPECT_EQ(rolling(model, {"knuckle_joint", "rear_joint"}), "chassis knuckle front rear");
}

std::string arm_with(const std::string& effort, const std::string& inertia, const std::string& mass) {
  std::string out;
  for (const char* name : {"base", "one", "two"})
    out += "<link name='" + std::string(name) + "'><inertial><mass value='" + mass + "'/><inertia ixx='" + inertia +
           "' iyy='" + inertia + "' izz='" + inertia + "' ixy='0' ixz='0' iyz='0'/></inertial></link>";
  for (const auto& [joint, parent, child] : {std::tuple{"a", "base", "one"}, std::tuple{"b", "one", "two"}})
    out += "<joint name='" + std::string(joint) + "' type='revolute'><parent link='" + parent + "'/><child link='" +
           child + "'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='" + effort + "'/></joint>";
  return out;
}

TEST(Bodies, RoundNumbersEverywhereLookLikePlaceholders) {
  EXPECT_TRUE(description::placeholders(read(arm_with("28", "0.01", "2"))).empty());
  for (const char* effort : {"1", "1000"})
    EXPECT_EQ(description::placeholders(read(arm_with(effort, "0.01", "2"))).size(), 1u) << effort;
  const auto all = description::placeholders(read(arm_with("1", "1", "1")));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_NE(all[1].find("base, one, two"), std::string::npos) << all[1];
}

/// Neither a joint that no hardware lists nor a round wrist makes an arm a caster of its base.
TEST(Bodies, AnArmOnABaseIsNoCasterWhateverHardwareLists) {
  const std::string
      wheels = wheel("left", "chassis", "0 0.2 0.1") + wheel("right", "chassis", "0 -0.2 0.1"),
      arm = joint("arm", "revolute", "chassis", "0 1 0") + wheel("wrist", "arm", "0 0 0.4"),
      roller = wheel("roller", "chassis", "0.3 0 0.05"),
      hardware =
          "<ros2_control name='b' type='system'><hardware><plugin>p/P</plugin></hardware>"
          "<joint name='left_joint'><command_interface name='velocity'/></joint>"
          "<joint name='right_joint'><command_interface name='velocity'/></joint></ros2_control>";
  const RobotModel model = read("<link name='chassis'/>" + wheels + arm + roller + hardware);
  EXPECT_EQ(rolling(model, {"left_joint", "right_joint"}), "chassis left right roller");
}

}  // namespace
}  // namespace polyarm::bodies_test
