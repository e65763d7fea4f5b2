#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::ros2_control_schema_test {
namespace {

using test::has;

/// Four lines of a robot with a turning joint `one`, a second one `two`, a follower `slave` and a fixed
/// `flange`; `body` starts on line 10.
std::string robot(const std::string& body) {
  return "<robot name=\"r\">\n<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/><link name=\"d\"/><link "
         "name=\"e\"/>\n"
         "<joint name=\"one\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/>\n"
         "<limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"50\"/></joint>\n"
         "<joint name=\"two\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/></joint>\n"
         "<joint name=\"slave\" type=\"continuous\"><parent link=\"c\"/><child link=\"d\"/>\n"
         "<mimic joint=\"one\"/></joint>\n"
         "<joint name=\"flange\" type=\"fixed\"><parent link=\"d\"/><child link=\"e\"/></joint>\n\n" +
         body + "</robot>\n";
}

/// A block around `body`, which starts on line 11.
std::string block(const std::string& body, const std::string& attributes = "name=\"h\" type=\"system\"") {
  return robot("<ros2_control " + attributes + "><hardware><plugin>p/P</plugin></hardware>\n" + body +
               "</ros2_control>\n");
}

RobotModel read(const std::string& text, Problems& warnings) {
  return read_urdf(text, "r.urdf", warnings);
}

RobotModel read(const std::string& text) {
  Problems warnings;
  const RobotModel out = read(text, warnings);
  EXPECT_TRUE(warnings.list().empty()) << warnings.list()[0].text();
  return out;
}

/// Everything that the schema has, in three blocks.
const char* const kEverything = R"(<ros2_control name="arm" type="system" rw_rate="250" is_async="true">
  <hardware>
    <plugin>vendor/Arm</plugin>
    <group>cell</group>
    <param name="address">10.0.0.2</param>
  </hardware>
  <properties>
    <async affinity="[2, 4]" scheduling_policy="detached" thread_priority="30" print_warnings="false"/>
  </properties>
  <joint name="one">
    <limits enable="true"/>
    <command_interface name="position">
      <param name="min">-1</param><param name="max">1.5</param><param name="custom">word</param>
    </command_interface>
    <command_interface name="velocity"><limits enable="false"/><param name="max">9</param></command_interface>
    <state_interface name="position"><param name="initial_value">0.25</param></state_interface>
    <param name="can_id">7</param>
  </joint>
  <joint name="slave" mimic="false">
    <limits enable="false"/>
    <command_interface name="position"/>
  </joint>
  <sensor name="wrist"><state_interface name="force.z"/><param name="frame">tool0</param></sensor>
  <gpio name="valves">
    <command_interface name="air" data_type="bool"><param name="initial_value">true</param></command_interface>
    <state_interface name="bits" data_type="uint8" size="16"/>
  </gpio>
  <transmission name="belt">
    <plugin>transmission_interface/SimpleTransmission</plugin>
    <joint name="one" role="joint1" read_only="true">
      <mechanical_reduction>50</mechanical_reduction><offset>0.5</offset>
    </joint>
    <actuator name="motor" role="actuator1"/>
    <param name="ticks">4096</param>
  </transmission>
</ros2_control>
<ros2_control name="lift" type="actuator">
  <hardware><plugin>vendor/Lift</plugin></hardware>
  <joint name="two"><command_interface name="velocity"/></joint>
</ros2_control>
<ros2_control name="scale" type="sensor">
  <hardware><plugin>vendor/Scale</plugin></hardware>
  <sensor name="load"><state_interface name="mass" data_type="float32"/></sensor>
</ros2_control>
)";

void expect_everything(const RobotModel& model) {
  ASSERT_EQ(model.hardware.size(), 3u);
  const HardwareInfo& arm = model.hardware[0];
  EXPECT_EQ(arm.type + model.hardware[1].type + model.hardware[2].type, "systemactuatorsensor");
  EXPECT_EQ(arm.plugin, "vendor/Arm");
  EXPECT_EQ(arm.group, "cell");
  EXPECT_EQ(arm.parameters, (std::map<std::string, std::string>{{"address", "10.0.0.2"}}));
  EXPECT_EQ(arm.rw_rate, 250);
  EXPECT_TRUE(arm.is_async);
  EXPECT_EQ(arm.affinity, (std::vector<int>{2, 4}));
  EXPECT_EQ(arm.scheduling_policy, "detached");
  EXPECT_EQ(arm.thread_priority, 30);
  EXPECT_FALSE(arm.print_warnings);
  EXPECT_FALSE(model.hardware[1].is_async);
  ASSERT_EQ(arm.components.size(), 4u);
  const ComponentInfo& one = arm.components[0];
  ASSERT_EQ(one.command_interfaces.size(), 2u);
  EXPECT_EQ(one.command_interfaces[0].min, -1);
  EXPECT_EQ(one.command_interfaces[0].max, 1.5);
  EXPECT_EQ(one.command_interfaces[0].parameters.at("custom"), "word");
  EXPECT_TRUE(one.command_interfaces[0].limits_enabled);
  EXPECT_FALSE(one.command_interfaces[1].limits_enabled);
  EXPECT_EQ(one.state_interfaces.at(0).initial_value, 0.25);
  EXPECT_EQ(one.parameters.at("can_id"), "7");
  EXPECT_FALSE(one.mimic.has_value());
  EXPECT_EQ(arm.components[1].mimic, false);
  EXPECT_FALSE(arm.components[1].limits_enabled);
  EXPECT_FALSE(arm.components[1].command_interfaces.at(0).limits_enabled);
  EXPECT_EQ(arm.components[2].kind, "sensor");
  EXPECT_EQ(arm.components[2].parameters.at("frame"), "tool0");
  EXPECT_EQ(arm.components[3].command_interfaces.at(0).data_type, "bool");
  EXPECT_EQ(arm.components[3].command_interfaces.at(0).initial_value, 1);
  EXPECT_EQ(arm.components[3].state_interfaces.at(0).size, 16);
  ASSERT_EQ(arm.transmissions.size(), 1u);
  const TransmissionInfo& belt = arm.transmissions[0];
  EXPECT_EQ(belt.name, "belt");
  EXPECT_EQ(belt.plugin, "transmission_interface/SimpleTransmission");
  EXPECT_EQ(belt.joints.at(0).reduction, 50);
  EXPECT_EQ(belt.joints.at(0).offset, 0.5);
  EXPECT_TRUE(belt.joints.at(0).read_only);
  EXPECT_EQ(belt.actuators.at(0).role, "actuator1");
  EXPECT_EQ(belt.actuators.at(0).reduction, 1);
  EXPECT_EQ(belt.parameters.at("ticks"), "4096");
}

TEST(Ros2ControlSchema, ReadsEveryTagAndAttribute) {
  expect_everything(read(robot(kEverything)));
}

TEST(Ros2ControlSchema, IsWrittenSoThatItReadsBack) {
  expect_everything(read(write_urdf(read(robot(kEverything)))));
}

TEST(Ros2ControlSchema, HasTheStatedDefaults) {
  const RobotModel model = read(block("<joint name=\"one\"><state_interface name=\"position\"/></joint>\n"));
  const HardwareInfo& h = model.hardware.at(0);
  EXPECT_EQ(h.rw_rate, 0);
  EXPECT_FALSE(h.is_async);
  EXPECT_EQ(h.thread_priority, 0);
  EXPECT_EQ(h.scheduling_policy, "synchronized");
  EXPECT_TRUE(h.print_warnings);
  const InterfaceInfo& position = h.components.at(0).state_interfaces.at(0);
  EXPECT_EQ(position.data_type, "double");
  EXPECT_EQ(position.size, 1);
  EXPECT_TRUE(position.limits_enabled);
  EXPECT_EQ(position.where.line, 11);
}

TEST(DataTypes, HaveTheirDefaultValues) {
  EXPECT_TRUE(std::isnan(default_value("double").value()));
  EXPECT_TRUE(std::isnan(default_value("float32").value()));
  EXPECT_EQ(default_value("bool"), 0);
  EXPECT_EQ(default_value("uint8"), 255);
  EXPECT_EQ(default_value("int8"), 127);
  EXPECT_EQ(default_value("uint16"), 65535);
  EXPECT_EQ(default_value("int16"), 32767);
  EXPECT_EQ(default_value("uint32"), 4294967295);
  EXPECT_EQ(default_value("int32"), 2147483647);
  EXPECT_FALSE(default_value("string"));
  for (const std::string& type : data_types()) EXPECT_TRUE(default_value(type)) << type;
}

// --- refused, with line, reason and what to write

struct Bad {
  const char* name;
  std::string text;
  int line;
  std::string code, what, advice;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadRos2Control : public ::testing::TestWithParam<Bad> {};

TEST_P(BadRos2Control, IsRefusedWithLineReasonAndAdvice) {
  Problems warnings;
  try {
    read(GetParam().text, warnings);
    warnings.throw_if_errors();  // as those do who use the hardware
    FAIL() << "was accepted";
  } catch (const Error& e) {
    const auto error = std::find_if(e.problems().begin(), e.problems().end(),
                                    [](const Problem& p) { return p.severity == Severity::error; });
    ASSERT_NE(error, e.problems().end());
    const Problem& first = *error;
    EXPECT_EQ(first.where.file, "r.urdf");
    EXPECT_EQ(first.where.line, GetParam().line) << first.text();
    EXPECT_EQ(first.code, GetParam().code) << first.text();
    EXPECT_TRUE(has(first.what, GetParam().what));
    EXPECT_TRUE(has(first.advice, GetParam().advice));
  }
}

std::string interface(const std::string& attributes, const std::string& inside = {}) {
  return block("<joint name=\"one\">\n<state_interface " + attributes + ">" + inside +
               "</state_interface></joint>\n");
}

std::vector<Bad> bad_blocks() {
  const auto transmission = [](const std::string& inside) {
    return block("<joint name=\"one\"/>\n<transmission name=\"t\">" + inside + "</transmission>\n");
  };
  const std::string plugin = "<plugin>transmission_interface/SimpleTransmission</plugin>";
  return {
      {"NoType", block("", "name=\"h\""), 10, "missing-attribute", "'type'", "type=\"system\""},
      {"UnknownType", block("", "name=\"h\" type=\"sistem\""), 10, "bad-type", "did you mean 'system'",
       "system, actuator or sensor"},
      {"UnknownTag", block("<jiont name=\"one\"/>\n"), 11, "unknown-tag", "did you mean 'joint'", "<gpio>"},
      {"ForeignTag", block("<banana/>\n"), 11, "unknown-tag", "<banana>", "<transmission>"},
      {"SlipInAComponent", block("<joint name=\"one\">\n<comand_interface name=\"x\"/></joint>\n"), 12,
       "unknown-tag", "did you mean 'command_interface'", "<state_interface>"},
      {"RateBelowZero", block("", "name=\"h\" type=\"system\" rw_rate=\"-5\""), 10, "bad-value",
       "rw_rate=\"-5\"", ""},
      {"RateOfAFraction", block("", "name=\"h\" type=\"system\" rw_rate=\"2.5\""), 10, "bad-value", "2.5",
       ""},
      {"RateBeyondNumbers", block("", "name=\"h\" type=\"system\" rw_rate=\"1e300\""), 10, "bad-value",
       "1e300", ""},
      {"AsyncNeitherTrueNorFalse", block("", "name=\"h\" type=\"system\" is_async=\"yes!\""), 10, "bad-value",
       "is_async", "true or false"},
      {"PriorityZero", block("", "name=\"h\" type=\"system\" thread_priority=\"0\""), 10, "bad-value",
       "at least 1", ""},
      {"UnknownPolicy",
       block("<properties>\n<async scheduling_policy=\"syncronized\"/></properties>\n",
             "name=\"h\" type=\"system\" is_async=\"true\""),
       12, "bad-value", "did you mean 'synchronized'", "detached"},
      {"BadAffinity",
       block("<properties>\n<async affinity=\"[2,x]\"/></properties>\n",
             "name=\"h\" type=\"system\" is_async=\"true\""),
       12, "bad-number", "[2,x]", "affinity=\"[2,4]\""},
      {"JointWithoutName", block("<joint/>\n"), 11, "missing-attribute", "<joint> has no", "name="},
      {"InterfaceWithoutName", interface(""), 12, "missing-attribute", "<state_interface>",
       "name=\"position\""},
      {"ParamWithoutName", interface("name=\"x\"", "\n<param>1</param>"), 13, "missing-attribute", "<param>",
       "name="},
      {"MimicMaybe", block("<joint name=\"slave\" mimic=\"maybe\"/>\n"), 11, "bad-value", "maybe",
       "true or false"},
      {"SizeZero", interface("name=\"x\" size=\"0\""), 12, "bad-value", "size=\"0\"", "size=\"1\""},
      {"SizeWithAZeroInFront", interface("name=\"x\" size=\"012\""), 12, "bad-value", "012", ""},
      {"SizeBeyondMemory", interface("name=\"x\" size=\"99999999999999999999\""), 12, "bad-value", "9999",
       ""},
      {"SizeNegative", interface("name=\"x\" size=\"-1\""), 12, "bad-value", "-1", ""},
      {"UnknownDataType", interface("name=\"x\" data_type=\"flaot32\""), 12, "bad-type",
       "did you mean 'float32'", "double, float32, bool"},
      {"LimitsWithoutEnable", block("<joint name=\"one\">\n<limits/></joint>\n"), 12, "missing-attribute",
       "'enable'", "enable=\"false\""},
      {"TransmissionWithoutPlugin", transmission("<joint name=\"one\" role=\"joint1\"/>"), 12, "missing-tag",
       "no plugin", "SimpleTransmission"},
      {"TransmissionWithoutJoint", transmission(plugin), 12, "missing-tag", "no <joint>", "role=\"joint1\""},
      {"TransmissionWithoutRole", transmission(plugin + "\n<joint name=\"one\"/><joint name=\"two\"/>"), 13,
       "missing-attribute", "'role'", "role=\"joint1\""},
      {"ReductionOfWords",
       transmission(plugin + "<joint name=\"one\" role=\"joint1\">\n<mechanical_reduction>fifty"
                             "</mechanical_reduction></joint>"),
       13, "bad-number", "'fifty'", ""},
      {"ReductionOfZero",
       transmission(plugin + "\n<joint name=\"one\"><mechanical_reduction>0</mechanical_reduction></joint>"),
       13, "bad-value", "of 'one' is 0", "turns"},
      {"TransmissionOfAForeignJoint", transmission(plugin + "<joint name=\"two\" role=\"joint1\"/>"), 12,
       "unknown-joint", "which its <ros2_control> 'h' does not have", "<joint name=\"two\">"},
      {"Sdf", "<sdf version=\"1.9\"><model name=\"m\"/></sdf>", 1, "no-robot", "SDF", "URDF"},
      {"Mjcf", "<mujoco model=\"m\"><worldbody/></mujoco>", 1, "no-robot", "MJCF", "URDF"},
  };
}

INSTANTIATE_TEST_SUITE_P(Table, BadRos2Control, ::testing::ValuesIn(bad_blocks()),
                         [](const auto& test) { return std::string(test.param.name); });

// --- what some release of ROS 2 takes is mended

TEST(Ros2Control, LimitsOfAnInterfaceTheWrongWayRoundAreExchanged) {
  Problems warnings;
  const RobotModel model =
      read(interface("name=\"x\"", "<param name=\"min\">2</param><param name=\"max\">1</param>"), warnings);
  const InterfaceInfo& found = model.hardware.at(0).components.at(0).state_interfaces.at(0);
  EXPECT_EQ(found.min, 1);
  EXPECT_EQ(found.max, 2);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].code, "bad-limit");
  EXPECT_EQ(warnings.list()[0].where.line, 12);
}

TEST(Ros2Control, BlocksWithoutANameAndOfOneNameGetNamesOfTheirOwn) {
  Problems warnings;
  const std::string one =
      "<ros2_control name=\"h\" type=\"system\"><hardware><plugin>p</plugin></hardware></ros2_control>";
  const std::string none =
      "<ros2_control type=\"system\"><hardware><plugin>p</plugin></hardware></ros2_control>";
  const RobotModel model = read(robot(one + one + none + one), warnings);
  std::vector<std::string> names;
  for (const HardwareInfo& hardware : model.hardware) names.push_back(hardware.name);
  EXPECT_EQ(names, (std::vector<std::string>{"h", "h_2", model.name, "h_3"}));
  EXPECT_EQ(warnings.list().size(), 3u);
}

TEST(Ros2Control, JointsThatCannotBeDrivenAreLeftOutAndTheOthersStay) {
  Problems warnings;
  const RobotModel model =
      read(block("<joint name=\"onne\"/><joint name=\"flange\"/><joint name=\"one\"/>\n"), warnings);
  ASSERT_EQ(model.hardware.at(0).components.size(), 1u);
  EXPECT_EQ(model.hardware[0].components[0].name, "one");
  EXPECT_EQ(warnings.list().size(), 2u);
}

TEST(Ros2Control, AJointThatIsNamedTwiceHasTheInterfacesOfBoth) {
  Problems warnings;
  const RobotModel model = read(
      block(
          "<joint name=\"one\"><command_interface name=\"velocity\"/><state_interface "
          "name=\"velocity\"/><param name=\"id\">1</param></joint>\n<joint name=\"one\"><command_interface "
          "name=\"position\"/><command_interface name=\"velocity\"/><param name=\"id\">2</param></joint>\n"),
      warnings);
  ASSERT_EQ(model.hardware.at(0).components.size(), 1u);
  const ComponentInfo& one = model.hardware[0].components[0];
  ASSERT_EQ(one.command_interfaces.size(), 2u);
  EXPECT_EQ(one.command_interfaces[0].name, "velocity");
  EXPECT_EQ(one.command_interfaces[1].name, "position");
  EXPECT_EQ(one.state_interfaces.size(), 1u);
  EXPECT_EQ(one.parameters.at("id"), "1");
}

TEST(Ros2Control, AnActuatorMayHaveAGpioAlone) {
  Problems warnings;
  const RobotModel model = read(block("<gpio name=\"fan\"><command_interface name=\"power\"/></gpio>\n",
                                      "name=\"h\" type=\"actuator\""),
                                warnings);
  EXPECT_TRUE(warnings.list().empty());
  EXPECT_EQ(model.hardware.at(0).components.size(), 1u);
}

TEST(Ros2Control, CommandInterfacesOfAFollowerAreLeftOut) {
  Problems warnings;
  const RobotModel model = read(block("<joint name=\"slave\"><command_interface "
                                      "name=\"position\"/><state_interface name=\"position\"/></joint>\n"),
                                warnings);
  EXPECT_TRUE(model.hardware.at(0).components.at(0).command_interfaces.empty());
  EXPECT_EQ(model.hardware[0].components[0].state_interfaces.size(), 1u);
}

// --- accepted, with a word

struct Odd {
  const char* name;
  std::string text;
  int line;
  std::string code, piece;
};

void PrintTo(const Odd& odd, std::ostream* out) {
  *out << odd.name;
}

class OddRos2Control : public ::testing::TestWithParam<Odd> {};

TEST_P(OddRos2Control, IsAcceptedWithAWarning) {
  Problems warnings;
  EXPECT_EQ(read(GetParam().text, warnings).hardware.size(), 1u);
  ASSERT_EQ(warnings.list().size(), 1u);
  const Problem& first = warnings.list()[0];
  EXPECT_EQ(first.severity, Severity::warning);
  EXPECT_EQ(first.where.line, GetParam().line) << first.text();
  EXPECT_EQ(first.code, GetParam().code) << first.text();
  EXPECT_TRUE(has(first.text(), GetParam().piece));
}

std::vector<Odd> odd_blocks() {
  return {
      {"NoName", block("", "type=\"system\""), 10, "missing-attribute", "has no name; it is called"},
      {"EmptyName", block("", "name=\"\" type=\"system\""), 10, "missing-attribute", "write name="},
      {"TypeInCapitals", block("", "name=\"h\" type=\"System\""), 10, "bad-type", "read as 'system'"},
      {"ActuatorOfTwoJoints",
       block("<joint name=\"one\"/><joint name=\"two\"/>\n", "name=\"h\" type=\"actuator\""), 10, "bad-type",
       "has 2 joints, an actuator moves one; it is read as a system"},
      {"NoPlugin", robot("<ros2_control name=\"h\" type=\"system\"/>\n"), 10, "missing-tag",
       "names no plugin"},
      {"UnknownJoint", block("\n<joint name=\"onne\"/>\n"), 12, "unknown-joint",
       "did you mean 'one'?; it is left out"},
      {"FixedJoint", block("<joint name=\"flange\"/>\n"), 11, "fixed-joint", "which is fixed"},
      {"CommandedFollower", block("<joint name=\"slave\">\n<command_interface name=\"position\"/></joint>\n"),
       12, "mimic-commanded", "mimic=\"false\""},
      {"MimicTrueOfNoFollower", block("<joint name=\"two\" mimic=\"true\"/>\n"), 11, "no-mimic",
       "follows no other"},
      {"LegacyPriority", block("", "name=\"h\" type=\"system\" is_async=\"true\" thread_priority=\"40\""), 10,
       "superseded", "<properties><async thread_priority=\"40\"/></properties>"},
      {"AsyncOfAComponentThatIsNot", block("<properties>\n<async/></properties>\n"), 12, "no-effect",
       "is_async=\"true\""},
      {"UnknownAttribute", block("<joint name=\"one\" mimik=\"true\"/>\n"), 11, "unknown-attribute",
       "did you mean 'mimic'"},
      {"ForeignTagInAComponent", block("<joint name=\"one\">\n<banana/></joint>\n"), 12, "unknown-tag",
       "<banana>"},
      {"LimitsOfAGpio", block("<gpio name=\"g\">\n<limits enable=\"false\"/></gpio>\n"), 12, "no-effect",
       "interfaces"},
      {"TwoJointsOfOneName", block("<joint name=\"one\"/>\n<joint name=\"one\"/>\n"), 12, "duplicate-name",
       "has two of <joint name=\"one\">; they are taken as one"},
      {"WordsForAMin", interface("name=\"x\"", "<param name=\"min\">low</param>"), 12, "bad-number", "'low'"},
      {"TooMuchForAByte",
       interface("name=\"x\" data_type=\"uint8\"", "<param name=\"initial_value\">256</param>"), 12,
       "bad-number", "not a uint8"},
      {"CommandsOfASensor",
       block("<sensor name=\"s\">\n<command_interface name=\"x\"/></sensor>\n", "name=\"h\" type=\"sensor\""),
       12, "no-effect", "type=\"system\""},
      {"MimicAsAParameter", block("<joint name=\"two\"><param name=\"mimic\">one</param></joint>\n"), 11,
       "superseded", "<mimic joint=\"one\"/>"},
      {"ReductionAsRos1SpellsIt",
       block("<joint name=\"one\"/>\n<transmission name=\"t\"><plugin>p</plugin><joint name=\"one\" "
             "role=\"joint1\">"
             "\n<mechanicalReduction>50</mechanicalReduction></joint></transmission>\n"),
       13, "superseded", "<mechanical_reduction>"},
      {"TwoStatesOfOneName",
       block("<joint name=\"one\"><state_interface name=\"p\"/>\n<state_interface name=\"p\"/></joint>\n"),
       12, "duplicate-name", "the first counts"},
      {"TwoCommandsOfOneName",
       block("<joint name=\"one\"><command_interface name=\"p\"/>\n<command_interface "
             "name=\"p\"/></joint>\n"),
       12, "duplicate-name", "the first counts"},
      {"ParameterGivenTwice",
       block("<joint name=\"one\"><param name=\"k\">1</param>\n<param name=\"k\">2</param></joint>\n"), 12,
       "duplicate-name", "the last one counts"},
  };
}

INSTANTIATE_TEST_SUITE_P(Table, OddRos2Control, ::testing::ValuesIn(odd_blocks()),
                         [](const auto& test) { return std::string(test.param.name); });

// Kinematics needs no hardware: whatever is wrong with it, the robot is read whole.
TEST_P(BadRos2Control, LeavesTheRobotAsItIs) {
  if (GetParam().code == "no-robot") return;
  Problems found;
  const RobotModel model = read(GetParam().text, found), plain = read(robot(""));
  EXPECT_TRUE(found.has_errors());
  EXPECT_EQ(model.joint_names(), plain.joint_names());
  EXPECT_EQ(model.links.size(), plain.links.size());
}

TEST(Ros2ControlSchema, TakesAnInterfaceThatIsThereTwiceOnce) {
  Problems found;
  const RobotModel model = read(block("<joint name=\"one\"><state_interface name=\"position\"><param "
                                      "name=\"initial_value\">1</param></state_interface><state_interface "
                                      "name=\"velocity\"/><state_interface name=\"position\"/></joint>\n"),
                                found);
  const std::vector<InterfaceInfo>& states = model.hardware.at(0).components.at(0).state_interfaces;
  ASSERT_EQ(states.size(), 2u);
  EXPECT_EQ(states[0].name, "position");
  EXPECT_EQ(states[0].initial_value, 1);
  EXPECT_EQ(states[1].name, "velocity");
}

TEST(Ros2ControlSchema, LetsAFollowerBeCommandedWhereItOptsOut) {
  const RobotModel model =
      read(block("<joint name=\"slave\" mimic=\"false\"><command_interface name=\"position\"/></joint>\n"));
  EXPECT_EQ(model.hardware.at(0).components.at(0).mimic, false);
}

TEST(Ros2ControlSchema, LetsAFollowerBeReadOnly) {
  read(block("<joint name=\"slave\"><state_interface name=\"position\"/></joint>\n"));
}

// --- transmissions of ROS 1

TEST(RobotTransmission, IsReadWithInterfacesAndReduction) {
  const RobotModel model = read(robot(R"(<transmission name="tran1">
  <type>transmission_interface/SimpleTransmission</type>
  <joint name="one"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
  <actuator name="motor1">
    <hardwareInterface>EffortJointInterface</hardwareInterface>
    <mechanicalReduction>50</mechanicalReduction>
  </actuator>
</transmission>
)"));
  for (const RobotModel& m : {model, read(write_urdf(model))}) {
    ASSERT_EQ(m.transmissions.size(), 1u);
    const TransmissionInfo& t = m.transmissions[0];
    EXPECT_EQ(t.name, "tran1");
    EXPECT_EQ(t.plugin, "transmission_interface/SimpleTransmission");
    EXPECT_EQ(t.joints.at(0).name, "one");
    EXPECT_EQ(t.joints.at(0).interfaces,
              (std::vector<std::string>{"hardware_interface/EffortJointInterface"}));
    EXPECT_EQ(t.actuators.at(0).reduction, 50);
  }
  EXPECT_EQ(model.transmissions[0].where.line, 10);
}

TEST(RobotTransmission, TakesTheOldestFormsToo) {
  const RobotModel model =
      read(robot("<transmission type=\"pr2_mechanism_model/SimpleTransmission\" name=\"t\">"
                 "<actuator name=\"m\"/><joint name=\"one\"/>"
                 "<mechanicalReduction>-75.5</mechanicalReduction></transmission>\n"));
  EXPECT_EQ(model.transmissions.at(0).plugin, "pr2_mechanism_model/SimpleTransmission");
  EXPECT_EQ(model.transmissions.at(0).actuators.at(0).reduction, -75.5);
}

TEST(RobotTransmission, WarnsOfJointsThatAreNotThere) {
  Problems warnings;
  read(robot("<transmission name=\"t\"><type>T</type><joint name=\"onne\"/></transmission>\n"), warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_TRUE(has(warnings.list()[0].text(), "r.urdf:10"));
  EXPECT_TRUE(has(warnings.list()[0].text(), "did you mean 'one'"));
}

// --- damage

TEST(Ros2ControlFuzz, DamagedTextEndsInAModelOrAnError) {
  const std::string good = robot(kEverything);
  test::Mutator mutate(77);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::string text = mutate(good);
    Problems warnings;
    try {
      const RobotModel model = read(text, warnings);
      ++accepted;
      Problems again;
      EXPECT_NO_THROW(read(write_urdf(model), again)) << text;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace polyarm::description::ros2_control_schema_test
