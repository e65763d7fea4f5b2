#include <gtest/gtest.h>

#include "polyarm/launch/python_launch.hpp"
#include "tests/description/support.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_files::markup_launch_test {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

/// The packages arm_bringup and arm_description in a folder.
struct Workspace {
  test::Folder folder;
  std::string controllers =
      folder.write("arm_bringup/config/c.yaml",
                   "controller_manager: {ros__parameters: {}}\njsb: {ros__parameters: {}}\n"
                   "arm: {ros__parameters: {joints: [$(var prefix)a]}}\n");
  std::string description = folder.write("arm_description/urdf/arm.urdf.xacro", "<robot/>");
  PackageSearch find = [this](const std::string& name) {
    const auto at = folder.path() / name;
    return std::filesystem::exists(at) ? at : std::filesystem::path();
  };
  PythonLaunch read(const std::string& name, const std::string& text,
                    const std::map<std::string, std::string>& given = {}) const {
    const auto file = folder.write("arm_bringup/launch/" + name, text);
    EXPECT_TRUE(is_ros2_launch(text, file)) << name;
    return read_python_launch(text, file, given, find);
  }
};

constexpr const char* kXml = R"xml(<launch>
  <arg name="prefix" default="left_"/>
  <arg name="sim" default="true"><choice value="true"/><choice value="false"/></arg>
  <let name="model" value="$(find-pkg-share arm_description)/urdf/arm.urdf.xacro"/>
  <node pkg="robot_state_publisher" exec="robot_state_publisher">
    <param name="robot_description" value="$(command 'xacro $(var model) prefix:=$(var prefix) sim:=$(var sim)')"/>
  </node>
  <node pkg="controller_manager" exec="ros2_control_node">
    <param from="$(find-pkg-share arm_bringup)/config/c.yaml"/>
  </node>
  <group if="$(var sim)">
    <node pkg="controller_manager" exec="spawner" args="jsb arm -c /controller_manager"/>
  </group>
  <group unless="$(var sim)"><node pkg="controller_manager" exec="spawner" args="real"/></group>
  <node pkg="rviz2" exec="rviz2" args="-d $(find-pkg-share arm_bringup)/x.rviz"/>
</launch>
)xml";

constexpr const char* kYaml = R"yaml(launch:
- arg: {name: prefix, default: left_}
- arg: {name: sim, default: 'true'}
- let: {name: model, value: $(find-pkg-share arm_description)/urdf/arm.urdf.xacro}
- node:
    pkg: robot_state_publisher
    exec: robot_state_publisher
    param:
    - name: robot_description
      value: "$(command 'xacro $(var model) prefix:=$(var prefix) sim:=$(var sim)')"
- node:
    pkg: controller_manager
    exec: ros2_control_node
    param: [{from: $(find-pkg-share arm_bringup)/config/c.yaml}]
- group:
  - node: {pkg: controller_manager, exec: spawner, args: jsb}
- executable: {cmd: ros2 control load_controller --set-state active arm, if: $(var sim)}
- executable: {cmd: ros2 control load_controller --set-state active real, unless: $(var sim)}
)yaml";

TEST(MarkupLaunch, XmlAndYamlSayWhatPythonSays) {
  const Workspace ws;
  for (const PythonLaunch& launch : {ws.read("arm.launch.xml", kXml), ws.read("arm.launch.yaml", kYaml)}) {
    EXPECT_EQ(launch.line(), "polyarm run --description " + ws.description + " --controllers " +
                                 ws.controllers + " --activate arm --activate jsb prefix:=left_ sim:=true");
    EXPECT_TRUE(launch.not_taken.empty());
    EXPECT_EQ(launch.arguments.size(), 2u);
  }
  EXPECT_EQ(ws.read("arm.launch.xml", kXml, {{"sim", "false"}}).spawned, (std::vector<std::string>{"real"}));
  EXPECT_EQ(ws.read("arm.launch.xml", kXml).descriptions.at(0).where.line, 6);
}

TEST(MarkupLaunch, ProcessingInstructionsAreValidAnywhere) {
  const Workspace ws;
  std::string text = kXml;
  text.insert(text.find('>', text.find("<launch")) + 1, "<?python it's math ?>");
  EXPECT_EQ(ws.read("arm.launch.xml", text).line(), ws.read("arm.launch.xml", kXml).line());
}

TEST(MarkupLaunch, APackageThatIsNotFoundIsSaidAndGivesNoPathFromTheRoot) {
  const Workspace ws;
  const PythonLaunch launch = ws.read(
      "a.launch.yaml",
      "launch:\n- node:\n    pkg: robot_state_publisher\n    exec: robot_state_publisher\n    param:\n"
      "    - {name: robot_description, value: $(command 'xacro $(find-pkg-share nowhere)/urdf/a.xacro')}\n"
      "- node: {pkg: controller_manager, exec: n, param: [{from: $(find-pkg-share nowhere)/c.yaml}]}\n");
  EXPECT_EQ(launch.missing_packages, (std::vector<std::string>{"nowhere"}));
  EXPECT_TRUE(launch.descriptions.empty());
  EXPECT_TRUE(launch.parameters.empty());
  ASSERT_EQ(launch.not_taken.size(), 2u);
  EXPECT_EQ(launch.not_taken[0].first.line, 6);
  EXPECT_NE(launch.not_taken[0].second.find("nowhere"), std::string::npos);
}

TEST(MarkupLaunch, AnArgumentWithoutADefaultIsToBeFilledIn) {
  const Workspace ws;
  const PythonLaunch launch = ws.read("a.launch.xml",
                                      "<launch><arg name='tf_prefix'/><node pkg='x' exec='y'><param "
                                      "name='robot_description' value=\"$(command "
                                      "'xacro $(find-pkg-share arm_description)/urdf/arm.urdf.xacro "
                                      "prefix:=$(var tf_prefix)')\"/></node></launch>");
  EXPECT_EQ(launch.needed(), (std::vector<PythonLaunchNeed>{{"prefix", "tf_prefix"}}));
  EXPECT_TRUE(launch.line().ends_with(" prefix:=VALUE")) << launch.line();
}

TEST(MarkupLaunch, IncludesGoFromOneFormToTheOther) {
  const Workspace ws;
  ws.folder.write(
      "arm_bringup/launch/inner.launch.py",
      "DeclareLaunchArgument('sim')\nd = Command(['xacro /ws/a.xacro sim:=', LaunchConfiguration('sim')])\n");
  const PythonLaunch launch = ws.read("a_launch.yml",
                                      "launch:\n- include:\n    file: $(dirname)/inner.launch.py\n    arg:\n"
                                      "    - {name: sim, value: 'yes'}\n");
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].arguments, (Pairs{{"sim", "yes"}}));
  ws.folder.write("arm_bringup/launch/inner.launch.xml", kXml);
  const PythonLaunch outer = ws.read("o.launch.py",
                                     "IncludeLaunchDescription(XMLLaunchDescriptionSource(os.path.join(\n  "
                                     "FindPackageShare('arm_bringup'), 'launch/inner.launch.xml')))\n");
  EXPECT_EQ(outer.spawned, (std::vector<std::string>{"jsb", "arm"}));
}

TEST(MarkupLaunch, ExpressionsAndUnknownConditionsAreSaid) {
  const Workspace ws;
  const std::string begin = "<launch><arg name='n' default='2'/><arg name='x'/>";
  const std::string node = "<node pkg='controller_manager' exec='spawner' args='arm'/>";
  EXPECT_EQ(
      ws.read("a.launch.xml", begin + "<group if=\"$(eval '$(var n) > 1')\">" + node + "</group></launch>")
          .spawned,
      (std::vector<std::string>{"arm"}));
  const PythonLaunch open =
      ws.read("a.launch.xml", begin + "<group if='$(var x)'>" + node + "</group></launch>");
  EXPECT_FALSE(open.spawned_known);
  EXPECT_FALSE(open.not_taken.empty());
}

TEST(MarkupLaunch, OtherFilesAreNone) {
  EXPECT_FALSE(is_ros2_launch("<launch><node pkg='a' type='b'/></launch>", "a.launch"));
  EXPECT_FALSE(is_ros2_launch("robots: []\n", "launch.yaml"));
  EXPECT_FALSE(is_ros2_launch("<robot/>", "a.launch.xml"));
}

TEST(MarkupLaunchFuzz, AnythingEndsInAResultOrASentence) {
  const Workspace ws;
  description::test::Mutator mutate(7);
  for (int i = 0; i < 600; ++i)
    for (const char* text : {kXml, kYaml}) {
      const std::string damaged = mutate(text);
      Problems problems;
      collect(problems, [&] {
        read_python_launch(damaged, text == kXml ? "/ws/a.launch.xml" : "/ws/a.launch.yaml", {}, ws.find);
      });
      for (const Problem& problem : problems.list()) EXPECT_FALSE(problem.what.empty());
    }
}

}  // namespace
}  // namespace polyarm::ros_files::markup_launch_test
