#include <gtest/gtest.h>

#include "polyarm/description/urdf.hpp"

namespace polyarm::description::ros2_control_test {
namespace {

std::string robot(const std::string& blocks) {
  return "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>"
         "<joint name='j' type='revolute'><parent link='a'/><child link='b'/><limit lower='-1' upper='1' "
         "velocity='1' effort='1'/></joint>"
         "<joint name='m' type='revolute'><parent link='b'/><child link='c'/><limit lower='-1' upper='1' "
         "velocity='1' effort='1'/><mimic joint='j'/></joint>"
         "<joint name='f' type='fixed'><parent link='c'/><child link='d'/></joint>\n" +
         blocks + "</robot>";
}

RobotModel read(const std::string& blocks) {
  Problems found;
  RobotModel out = read_urdf(robot(blocks), "r.urdf", found);
  found.throw_if_errors();
  return out;
}

std::string refusal(const std::string& inner, const std::string& attributes = "name='h' type='system'") {
  try {
    read("<ros2_control " + attributes + "><hardware><plugin>p</plugin></hardware>" + inner +
         "</ros2_control>");
  } catch (const Error& e) {
    for (const Problem& problem : e.problems()) {
      if (problem.severity != Severity::error) continue;
      EXPECT_GE(problem.where.line, 2);
      return problem.code;
    }
  }
  return "none";
}

TEST(Ros2Control, EveryAttributeIsRead) {
  const RobotModel model = read(
      "<ros2_control name='arm' type='system' rw_rate='500' is_async='true'><properties><async "
      "affinity='[2,4]' thread_priority='60'/></properties>"
      "<hardware><plugin>v/P</plugin><group>g</group><param name='port'> /dev/x </param></hardware>"
      "<joint name='j'><limits enable='false'/><command_interface name='position'><param "
      "name='min'>-0.5</param></command_interface>"
      "<state_interface name='mode' data_type='uint8' size='3'><param "
      "name='initial_value'>4</param></state_interface></joint>"
      "<gpio name='io'><command_interface name='out' data_type='bool'/></gpio>"
      "<transmission name='t'><plugin>transmission_interface/SimpleTransmission</plugin>"
      "<joint name='j' "
      "role='joint1'><mechanical_reduction>10</mechanical_reduction><offset>1</offset></joint><actuator "
      "name='motor'/></transmission>"
      "</ros2_control>"
      "<ros2_control name='wrist' type='sensor'><hardware><plugin>v/S</plugin></hardware><sensor "
      "name='ft'><state_interface name='force.x'/></sensor></ros2_control>");
  ASSERT_EQ(model.hardware.size(), 2u);
  const HardwareInfo& arm = model.hardware[0];
  EXPECT_EQ(arm.rw_rate, 500);
  EXPECT_TRUE(arm.is_async);
  EXPECT_EQ(arm.thread_priority, 60);
  EXPECT_EQ(arm.affinity, (std::vector<int>{2, 4}));
  EXPECT_EQ(arm.group, "g");
  EXPECT_EQ(arm.parameters.at("port"), "/dev/x");
  EXPECT_FALSE(arm.components[0].limits_enabled);
  EXPECT_EQ(arm.components[0].state_interfaces[0].size, 3);
  EXPECT_EQ(arm.components[0].state_interfaces[0].initial_value, 4);
  ASSERT_EQ(arm.transmissions.size(), 1u);
  EXPECT_EQ(arm.transmissions[0].joints[0].reduction, 10);
  EXPECT_EQ(arm.transmissions[0].joints[0].offset, 1);
  EXPECT_EQ(arm.transmissions[0].actuators[0].name, "motor");
  EXPECT_EQ(model.hardware[1].type, "sensor");
}

TEST(Ros2Control, AReductionInRos1sSpellingCountsUnlessThereIsOneInItsOwn) {
  const auto reduction = [](const std::string& inside) {
    return read(
               "<ros2_control name='h' type='system'><hardware><plugin>p</plugin></hardware><joint name='j'/>"
               "<transmission name='t'><plugin>p</plugin><joint name='j' role='joint1'>" +
               inside + "</joint></transmission></ros2_control>")
        .hardware[0]
        .transmissions[0]
        .joints[0]
        .reduction;
  };
  EXPECT_EQ(reduction("<mechanicalReduction>50</mechanicalReduction>"), 50);
  EXPECT_EQ(
      reduction(
          "<mechanicalReduction>50</mechanicalReduction><mechanical_reduction>20</mechanical_reduction>"),
      20);
}

TEST(Ros2Control, WhatIsWrongIsRefusedByName) {
  EXPECT_EQ(refusal("<joint name='j'/>"), "none");
  EXPECT_EQ(refusal("<joint name='jj'/>"), "none");
  EXPECT_EQ(refusal("<joint name='f'/>"), "none");
  EXPECT_EQ(refusal("<joint name='m'><command_interface name='position'/></joint>"), "none");
  EXPECT_EQ(refusal("<joint name='m' mimic='false'><command_interface name='position'/></joint>"), "none");
  EXPECT_EQ(refusal("<joint name='j' mimic='true'/>"), "none");
  EXPECT_EQ(refusal("<jiont name='j'/>"), "unknown-tag");
  EXPECT_EQ(refusal("<joint name='j'><comand_interface name='position'/></joint>"), "unknown-tag");
  EXPECT_EQ(refusal("<joint name='j'><state_interface/></joint>"), "missing-attribute");
  EXPECT_EQ(refusal("<joint name='j'><state_interface name='x' data_type='dobule'/></joint>"), "bad-type");
  EXPECT_EQ(refusal("<joint name='j'><state_interface name='x' size='0'/></joint>"), "bad-value");
  EXPECT_EQ(refusal("", "name='h' type='sytsem'"), "bad-type");
  EXPECT_EQ(refusal("", "name='h' type='system' rw_rate='-3'"), "bad-value");
  EXPECT_EQ(refusal("", "name='h' type='system' is_async='maybe'"), "bad-value");
  EXPECT_EQ(refusal("", "name='h' type='actuator'"), "none");
  EXPECT_EQ(refusal("<transmission name='t'><plugin>p</plugin><joint "
                    "name='j'><mechanical_reduction>0</mechanical_reduction></joint></transmission>"),
            "bad-value");
}

/// The interfaces with their components, in order: "j/position".
std::vector<std::string> names(const RobotModel& model, std::vector<InterfaceInfo> ComponentInfo::*list) {
  std::vector<std::string> out;
  for (const HardwareInfo& hardware : model.hardware)
    for (const ComponentInfo& component : hardware.components)
      for (const InterfaceInfo& interface : component.*list)
        out.push_back(component.name + "/" + interface.name);
  return out;
}

TEST(Ros2Control, AnInterfaceOfTwoElementsOfOneNameCountsOnceWithAWarning) {
  Problems warnings;
  const RobotModel model =
      read_urdf(robot("<ros2_control name='h' type='system'><hardware><plugin>p</plugin></hardware>\n"
                      "<sensor name='pad'><state_interface name='x'/><state_interface name='y'/></sensor>\n"
                      "<gpio name='pad'><command_interface name='x'/>\n<state_interface name='x'/>"
                      "<state_interface name='z'/></gpio></ros2_control>"),
                "r.urdf", warnings);
  EXPECT_EQ(names(model, &ComponentInfo::state_interfaces),
            (std::vector<std::string>{"pad/x", "pad/y", "pad/z"}));
  EXPECT_EQ(names(model, &ComponentInfo::command_interfaces), (std::vector<std::string>{"pad/x"}));
  ASSERT_EQ(warnings.list().size(), 1u);
  const Problem& warning = warnings.list()[0];
  EXPECT_EQ(warning.where.line, 5);
  EXPECT_EQ(warning.what,
            "the state interface 'pad/x' of this <gpio> exists already in the <sensor> of line 3; the first "
            "counts");
}

TEST(Ros2Control, AnInterfaceOfTwoBlocksCountsOnceWithAWarning) {
  Problems warnings;
  const std::string block =
      "<ros2_control name='NAME' type='system'><hardware><plugin>p</plugin></hardware>\n"
      "<joint name='j'><command_interface name='position'/><state_interface "
      "name='position'/></joint></ros2_control>";
  const RobotModel model = read_urdf(robot(block + block), "r.urdf", warnings);
  EXPECT_EQ(names(model, &ComponentInfo::state_interfaces), (std::vector<std::string>{"j/position"}));
  EXPECT_EQ(names(model, &ComponentInfo::command_interfaces), (std::vector<std::string>{"j/position"}));
  EXPECT_EQ(warnings.list().size(), 3u) << "and the name of the second block";
}

}  // namespace
}  // namespace polyarm::description::ros2_control_test
