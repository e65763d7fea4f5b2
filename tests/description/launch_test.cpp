#include <gtest/gtest.h>

#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::launch_test {
namespace {

using Names = std::vector<std::string>;

TEST(LaunchFile, IsKnownByItsName) {
  for (const char* name : {"a.launch", "a.launch.py", "a_launch.py", "folder/a.launch.xml", "a.launch.yaml", "launch.py",
                           "sim.py"})
    EXPECT_TRUE(is_launch_file(name)) << name;
  for (const char* name : {"a.xml", "a.urdf", "launch", "a.launch/robot.urdf"})
    EXPECT_FALSE(is_launch_file(name)) << name;
}

TEST(LaunchFile, InPythonNamesDescriptionAndControllers) {
  const LaunchHints hints = find_in_launch_file(R"(
    description = Command(["xacro ", PathJoinSubstitution([FindPackageShare("pkg"), "urdf", "arm.urdf.xacro"])])
    controllers = PathJoinSubstitution([FindPackageShare("pkg"), 'config', 'arm_controllers.yaml'])
    again = "arm_controllers.yaml"
  )");
  EXPECT_EQ(hints.descriptions, (Names{"arm.urdf.xacro"}));
  EXPECT_EQ(hints.controllers, (Names{"arm_controllers.yaml"}));
}

TEST(LaunchFile, TheEndOfAComputedNameIsNoName) {
  const LaunchHints hints = find_in_launch_file(R"(
    description = Command(["xacro ", share, "/urdf/", LaunchConfiguration("type"), ".urdf.xacro"])
    controllers = [name, '.yaml']
    other = './config/ctl.yaml'
  )");
  EXPECT_TRUE(hints.descriptions.empty());
  EXPECT_EQ(hints.controllers, (Names{"./config/ctl.yaml"}));
}

TEST(LaunchFile, InXmlNamesDescriptionAndControllers) {
  const LaunchHints hints = find_in_launch_file(
      "<launch><param name=\"robot_description\" textfile=\"$(find arm_pkg)/urdf/arm.urdf\"/>\n"
      "<rosparam file=\"config/ctl.yml\"/></launch>");
  ASSERT_EQ(hints.descriptions.size(), 1u);
  EXPECT_TRUE(hints.descriptions[0].ends_with("urdf/arm.urdf")) << hints.descriptions[0];
  EXPECT_EQ(hints.controllers, (Names{"config/ctl.yml"}));
}

TEST(LaunchFile, HintIsTheLineToType) {
  EXPECT_EQ((LaunchHints{{"arm.urdf"}, {"ctl.yaml"}}.line()),
            "polyarm run --description arm.urdf --controllers ctl.yaml");
  EXPECT_EQ((LaunchHints{{"arm.urdf"}, {}}.line()), "polyarm run --description arm.urdf");
  EXPECT_TRUE(test::has(LaunchHints{}.line(), "--description FILE.urdf"));
  EXPECT_EQ((LaunchHints{{"arm.urdf"}, {}}.line("check")), "polyarm check --description arm.urdf");
}

TEST(LaunchFile, ThatMentionsNothingGivesNoNames) {
  for (const char* text : {"", "import os\n", "\xff\xfe urdf yaml"}) {
    const LaunchHints hints = find_in_launch_file(text);
    EXPECT_TRUE(hints.descriptions.empty());
    EXPECT_TRUE(hints.controllers.empty());
  }
}

}  // namespace
}  // namespace polyarm::description::launch_test
