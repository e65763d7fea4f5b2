#include "polyarm/ros_files/launch_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "polyarm/base/text.hpp"
#include "tests/ros_files/launch_pieces.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm::ros_files {
namespace {

/// A folder with two packages, my_robot and other.
class Workspace {
 public:
  Workspace() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("polyarm_launch_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    for (const char* folder : {"my_robot/launch", "my_robot/config", "my_robot/urdf", "other/launch"})
      std::filesystem::create_directories(path_ / folder);
    write("my_robot/urdf/robot.urdf", "<robot name='r'><link name='a'/></robot>");
    write("my_robot/urdf/robot.xacro", "<robot name='r'/>");
  }
  ~Workspace() { std::filesystem::remove_all(path_); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  PackageSearch search() const {
    return [path = path_](const std::string& package) {
      return std::filesystem::is_directory(path / package) ? path / package : std::filesystem::path();
    };
  }

 private:
  std::filesystem::path path_;
};

struct Launched {
  LaunchedCell cell;
  Problems problems;
};

class LaunchFile : public testing::Test {
 protected:
  Launched read(const std::string& text, const std::map<std::string, std::string>& args = {}) {
    return read_file(space.write("my_robot/launch/main.launch", text), args);
  }
  Launched read_file(const std::filesystem::path& path, const std::map<std::string, std::string>& args = {}) {
    Launched out;
    out.cell = read_launch_file(path, args, space.search(), out.problems);
    return out;
  }
  std::string thrown(const std::string& text) {
    try {
      read(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing";
  }
  /// The one finding of a text, without the folder in its place.
  Problem only(const std::string& text, const std::map<std::string, std::string>& args = {}) {
    const Launched got = read(text, args);
    EXPECT_EQ(got.problems.list().size(), 1u) << all(got.problems) << text;
    return got.problems.list().empty() ? Problem{} : got.problems.list().front();
  }
  static std::string all(const Problems& problems) {
    std::string out;
    for (const Problem& problem : problems.list()) out += problem.text() + "\n";
    return out;
  }
  static std::string notes(const LaunchedCell& cell) {
    std::string out;
    for (const NotApplicable& note : cell.not_applicable)
      out += std::to_string(note.where.line) + ": " + note.what + "\n";
    return out;
  }
  static std::string spawned(const LaunchedCell& cell) {
    std::string out;
    for (const SpawnedController& one : cell.spawned)
      out += one.full_name() + (one.stopped ? "(stopped) " : " ");
    return out;
  }

  Workspace space;
};

// As MoveIt writes it into every move_group.launch.
TEST_F(LaunchFile, AConditionMayAskWhetherANameIsInAList) {
  const std::string begin =
      "<launch><arg name='p' default='ompl'/><include file='none.launch' if=\"$(eval arg('p') ";
  EXPECT_EQ(all(read(begin + "not in ['ompl', 'chomp'])\"/></launch>").problems), "");
  EXPECT_EQ(all(read(begin + "in ('a', 'b') or p == 'c')\"/></launch>").problems), "");
  EXPECT_EQ(only(begin + "in ['ompl', 'chomp'])\"/></launch>").code, "no-file");
}

TEST_F(LaunchFile, ProcessingInstructionsAreValidAnywhere) {
  EXPECT_EQ(
      all(read("<?xml version='1.0'?><!-- a --><?xml-model href='x'?><launch><?python it's?></launch><?z?>")
              .problems),
      "");
}

// The names and values are those of the page "ros_control" that prints them one by one.
TEST_F(LaunchFile, MyRobotBecomesACell) {
  space.write("my_robot/config/controllers.yaml", R"(MyRobot:
  joint_state_controller:
    type: joint_state_controller/JointStateController
    publish_rate: 50
  JointA_EffortController:
    type: effort_controllers/JointEffortController
    joint: JointA
    pid: {p: 100.0, i: 10.0, d: 1.0}
  JointC_PositionController:
    type: position_controllers/JointPositionController
    joint: JointC
)");
  space.write("my_robot/config/joint_limits.yaml",
              "joint_limits:\n  JointA: {has_velocity_limits: true, max_velocity: 1.5}\n");
  const auto [cell, problems] = read(R"xml(<launch>
  <param name="robot_description" textfile="$(find my_robot)/urdf/robot.urdf"/>
  <rosparam file="$(find my_robot)/config/controllers.yaml" command="load"/>
  <rosparam file="$(find my_robot)/config/joint_limits.yaml" command="load" ns="MyRobot"/>
  <node name="MyRobotHardwareInterface" pkg="my_robot" type="MyRobot_hardware_inerface_node" output="screen"/>
  <node name="robot_state_publisher" pkg="robot_state_publisher" type="robot_state_publisher"/>
  <node name="controller_spawner" pkg="controller_manager" type="spawner" ns="/MyRobot"
        args="joint_state_controller JointA_EffortController"/>
  <node name="rviz" pkg="rviz" type="rviz" args="-d $(find my_robot)/launch/view.rviz"/>
</launch>
)xml");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(cell.descriptions.size(), 1u);
  EXPECT_EQ(cell.descriptions[0].file, space / "my_robot/urdf/robot.urdf");
  EXPECT_FALSE(cell.descriptions[0].xacro);
  EXPECT_EQ(spawned(cell), "/MyRobot/joint_state_controller /MyRobot/JointA_EffortController ");
  EXPECT_EQ(notes(cell),
            "5: 'MyRobotHardwareInterface' (my_robot/MyRobot_hardware_inerface_node) is a ROS node\n"
            "6: 'robot_state_publisher' (robot_state_publisher/robot_state_publisher) is a ROS node\n"
            "9: 'rviz' (rviz/rviz) is a ROS node\n");
  Problems more;
  const ControllersFile controllers = read_controllers(cell, more);
  EXPECT_EQ(all(more), "");
  ASSERT_EQ(controllers.controllers.size(), 3u);
  EXPECT_TRUE(controllers.controllers[0].spawned);
  EXPECT_TRUE(controllers.controllers[1].spawned);
  EXPECT_FALSE(controllers.controllers[2].spawned);
  ASSERT_EQ(controllers.joint_limits.size(), 1u);
  EXPECT_EQ(controllers.joint_limits[0].ns, "/MyRobot");
  EXPECT_EQ(controllers.joint_limits[0].keys, std::vector<std::string>{"joint_limits"});
}

TEST_F(LaunchFile, XacroCommandsGiveFileAndArguments) {
  for (const char* command :
       {"xacro '$(find my_robot)/urdf/robot.xacro' prefix:=left_ limited:=$(arg limited)",
        "$(find xacro)/xacro --inorder $(find my_robot)/urdf/robot.xacro prefix:=left_ limited:=$(arg "
        "limited)",
        "$(find xacro)/xacro.py $(find my_robot)/urdf/robot.xacro prefix:='left_' limited:=$(arg limited)",
        "/opt/ros/noetic/bin/xacro ../urdf/robot.xacro prefix:=left_ limited:=$(arg limited)",
        "rosrun xacro xacro $(find my_robot)/urdf/robot.xacro prefix:=left_ limited:=$(arg limited)"}) {
    const auto [cell, problems] = read(
        "<launch><arg name='limited' default='true'/><group ns='arm'>\n"
        "<param name='robot_description' command=\"" +
        std::string(command) + "\"/></group></launch>");
    EXPECT_EQ(all(problems), "");
    ASSERT_EQ(cell.descriptions.size(), 1u);
    const LaunchedDescription& description = cell.descriptions[0];
    EXPECT_TRUE(description.xacro);
    EXPECT_EQ(description.parameter, "/arm/robot_description");
    EXPECT_EQ(description.file, space / "my_robot/urdf/robot.xacro") << command;
    EXPECT_EQ(description.arguments,
              (std::vector<std::pair<std::string, std::string>>{{"prefix", "left_"}, {"limited", "true"}}));
    EXPECT_EQ(description.where.line, 2);
  }
}

TEST_F(LaunchFile, ADescriptionMayBeCatOrTextAndSrdfStandsApart) {
  const auto [cell, problems] = read(R"xml(<launch>
<param name="robot_description" command="cat $(find my_robot)/urdf/robot.urdf"/>
<param name="robot_description" value="&lt;robot name='x'/&gt;"/>
<param name="robot_description_semantic" textfile="$(dirname)/../urdf/robot.urdf"/>
</launch>)xml");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(cell.descriptions.size(), 2u);
  EXPECT_FALSE(cell.descriptions[0].xacro);
  EXPECT_EQ(cell.descriptions[1].text, "<robot name='x'/>");
  EXPECT_EQ(cell.semantics.size(), 1u);
}

TEST_F(LaunchFile, ArgsComeFromOutsideOrTheirDefaults) {
  const std::string text = R"xml(<launch>
  <arg name="sim" default="true" doc="in physics"/>
  <arg name="robot"/>
  <arg name="both" value="$(arg robot)_$(arg sim)"/>
  <param name="x" value="$(arg both)"/>
</launch>)xml";
  const auto [cell, problems] = read(text, {{"robot", "ur3"}, {"sim", "false"}});
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(cell.parameters.at(0).text, "ur3_false");
  ASSERT_EQ(cell.args.size(), 3u);
  EXPECT_EQ(cell.args[0].doc, "in physics");
  EXPECT_TRUE(cell.args[1].required);
  EXPECT_TRUE(cell.args[2].fixed);
  EXPECT_EQ(read(text, {{"robot", "a"}}).cell.parameters.at(0).text, "a_true");
}

TEST_F(LaunchFile, IfAndUnlessChooseAndGroupsNest) {
  const auto [cell, problems] = read(R"xml(<launch>
  <arg name="sim" default="1"/>
  <group ns="a" if="$(arg sim)"><group ns="b"><param name="x" value="1"/></group><param name="/y" value="2"/></group>
  <group unless="$(arg sim)"><param name="z" value="3"/></group>
  <param name="w" value="4" if="$(eval sim and arg('sim') == 1 and not 'x' == 'y')"/>
</launch>)xml");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(cell.parameters.size(), 3u);
  EXPECT_EQ(cell.parameters[0].ns, "/a/b/x");
  EXPECT_EQ(cell.parameters[1].ns, "/y");
  EXPECT_EQ(cell.parameters[2].ns, "/w");
}

TEST_F(LaunchFile, IncludesPassArgsAndNamespaces) {
  space.write("other/launch/arm.launch", R"xml(<launch>
  <arg name="name"/>
  <arg name="rate" default="50"/>
  <node name="s" pkg="controller_manager" type="spawner" args="$(arg name)_controller"/>
  <param name="rate" value="$(arg rate)"/>
</launch>)xml");
  const auto [cell, problems] = read(R"xml(<launch>
  <arg name="rate" default="70"/><arg name="name" value="c"/><arg name="unrelated" default="5"/>
  <include file="$(find other)/launch/arm.launch" ns="left"><arg name="name" value="a"/></include>
  <include file="$(find other)/launch/arm.launch" ns="/right" pass_all_args="true"/>
</launch>)xml");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(spawned(cell), "/left/a_controller /right/c_controller ");
  EXPECT_EQ(cell.parameters.at(0).text, "50");
  EXPECT_EQ(cell.parameters.at(0).ns, "/left/rate");
  EXPECT_EQ(cell.parameters.at(1).text, "70");
  EXPECT_EQ(cell.args.size(), 3u);
}

TEST_F(LaunchFile, SpawnersSayNamespaceAndWhetherToStart) {
  const auto [cell, problems] = read(R"xml(<launch><group ns="g">
<node name="a" pkg="controller_manager" type="spawner" args="one two"/>
<node name="b" pkg="controller_manager" type="spawner" ns="n" args="--stopped three --timeout 20"/>
<node name="c" pkg="controller_manager" type="spawner" args="--namespace=/m --shutdown-timeout 5 four __log:=x"/>
<node name="d" pkg="controller_manager" type="spawner" args="--namespace m five --no-timeout"/>
<node name="e" pkg="controller_manager" type="controller_manager" args="spawn six"/>
<node name="f" pkg="controller_manager" type="controller_manager" args="load sub/seven"/>
<node name="h" pkg="controller_manager" type="controller_manager" args="list"/>
</group></launch>)xml");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(spawned(cell),
            "/g/one /g/two /g/n/three(stopped) /m/four /g/m/five /g/six /g/sub/seven(stopped) ");
  EXPECT_EQ(notes(cell), "8: controller_manager list: polyarm control does this\n");
}

TEST_F(LaunchFile, InlineParametersKeepTheirLines) {
  const auto [cell, problems] = read(R"xml(<launch>
  <rosparam ns="MyRobot">
    a_controller:
      type: x/Y
      joint: j
  </rosparam>
  <rosparam param="MyRobot/a_controller/list">[1, 2]</rosparam>
  <arg name="p" default="7"/>
  <rosparam subst_value="true">MyRobot/a_controller: {p: $(arg p), q: $(eval p * 2)}</rosparam>
  <param name="MyRobot/a_controller/r" value="8"/>
  <param name="MyRobot/a_controller/s" type="yaml" value="[5, 6]"/>
</launch>)xml");
  // $(eval …) stands alone or not at all.
  ASSERT_EQ(problems.list().size(), 1u) << all(problems);
  EXPECT_EQ(problems.list()[0].where.line, 9);
  Problems more;
  const ControllersFile file = read_controllers(cell, more);
  EXPECT_EQ(all(more), "");
  ASSERT_EQ(file.controllers.size(), 1u);
  const ControllerEntry& a = file.controllers[0];
  EXPECT_EQ(a.full_name(), "/MyRobot/a_controller");
  EXPECT_EQ(a.where.line, 4);
  EXPECT_EQ(a.parameters.list("list"), (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(a.parameters.entries.at("list").where.line, 7);
  EXPECT_EQ(a.parameters.number("r", 0), 8);
  EXPECT_EQ(a.parameters.entries.at("s").where.line, 11);
  EXPECT_EQ(a.parameters.list("s").size(), 2u);
}

TEST_F(LaunchFile, SubstitutionsInsideParameterFilesAreMadeWhereAskedFor) {
  space.write("my_robot/config/c.yaml", "c: {type: x/Y, joint: $(arg prefix)elbow}\n");
  const std::string text =
      "<launch><arg name='prefix' value='l_'/><rosparam file='../config/c.yaml' "
      "subst_value='true'/></launch>";
  const auto [cell, problems] = read(text);
  Problems more;
  EXPECT_EQ(read_controllers(cell, more).controllers.at(0).parameters.text("joint"), "l_elbow");
}

TEST_F(LaunchFile, PrivateParametersOfNodesStandBelowTheirNames) {
  const auto [cell, problems] = read(
      "<launch><node name='hw' ns='r' pkg='p' type='t'><param name='loop_hz' value='125'/>"
      "<remap from='a' to='b'/></node></launch>");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(cell.parameters.at(0).ns, "/r/hw/loop_hz");
  Problems more;
  EXPECT_EQ(read_controllers(cell, more).update_rate, 125);
}

TEST_F(LaunchFile, WhatACellDoesNotHaveIsListedByLine) {
  const auto [cell, problems] = read(R"xml(<launch>
<remap from="joint_states" to="/robot/joint_states"/>
<env name="A" value="b"/>
<machine name="m" address="x"/>
<test test-name="t" pkg="p" type="q"/>
<rosparam command="delete" param="/x"/>
<param name="big" binfile="x.bin"/>
<node pkg="controller_manager" type="unspawner" name="u"/>
</launch>)xml");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(cell.not_applicable.size(), 7u) << notes(cell);
  for (std::size_t i = 0; i < cell.not_applicable.size(); ++i)
    EXPECT_EQ(cell.not_applicable[i].where.line, static_cast<int>(i) + 2);
}

TEST_F(LaunchFile, APackageThatIsNotHereIsPassedOverWithAWarning) {
  const auto [cell, problems] =
      read("<launch>\n<include file='$(find gazebo_ros)/launch/empty_world.launch'/>\n</launch>");
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].severity, Severity::warning);
  EXPECT_EQ(problems.list()[0].where.line, 2);
  EXPECT_EQ(notes(cell), "2: '$(find gazebo_ros)/launch/empty_world.launch' is not here\n");
}

TEST_F(LaunchFile, AMissingPackageIsToldWhereSomethingIsReadFromIt) {
  const std::string arg = "<launch>\n<arg name='folder' default='$(find nowhere)/config'/>\n";
  EXPECT_EQ(all(read(arg + "</launch>").problems), "");
  for (const char* line : {"<rosparam file='$(arg folder)/a.yaml'/>",
                           "<param name='robot_description' command='xacro $(arg folder)/a.xacro'/>",
                           "<param name='robot_description' textfile='$(find nowhere)/a.urdf'/>"}) {
    const Problem problem = only(arg + line + "\n</launch>");
    EXPECT_EQ(problem.code, "no-package");
    EXPECT_EQ(problem.severity, Severity::error);
    EXPECT_EQ(problem.where.line, 3);
    EXPECT_NE(problem.what.find("'nowhere'"), std::string::npos) << problem.what;
  }
}

TEST_F(LaunchFile, ARelativeNameOfTheFileItselfIsEnough) {
  space.write("my_robot/launch/part.launch", "<launch><param name='x' value='1'/></launch>");
  const auto path = space.write("my_robot/launch/whole.launch",
                                "<launch><include file='$(dirname)/part.launch'/></launch>");
  const auto [cell, problems] = read_file(std::filesystem::relative(path));
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(cell.parameters.size(), 1u);
}

TEST_F(LaunchFile, AWrongLineIsToldWithItsPlaceAndWhatToWrite) {
  struct Wrong {
    const char* line;
    const char* code;
    const char* says;
  };
  for (const Wrong& wrong : {
           Wrong{"<param name='x' value='$(arg simm)'/>", "unknown-arg", "did you mean 'sim'?"},
           Wrong{"<param name='x' value='$(find nowhere)/a'/>", "no-package",
                 "names a ROS package that is not found"},
           Wrong{"<param name='x' value='$(env POLYARM_NEVER_SET)'/>", "no-variable",
                 "$(optenv POLYARM_NEVER_SET"},
           Wrong{"<param name='x' value='$(arg sim'/>", "bad-substitution", "no closing ')'"},
           Wrong{"<param name='x' value='$(fnd a)'/>", "bad-substitution", "did you mean 'find'?"},
           Wrong{"<param name='x' value='$(eval 1 / 0)'/>", "bad-substitution", "division by zero"},
           Wrong{"<param name='x' value='$(eval __import__(\"os\"))'/>", "bad-substitution",
                 "two underscores"},
           Wrong{"<param name='x' value='$(eval open(\"a\"))'/>", "bad-substitution", "no function 'open'"},
           Wrong{"<param name='x'/>", "missing-attribute", "has no value"},
           Wrong{"<param value='1'/>", "missing-attribute", "write name="},
           Wrong{"<group if='maybe'/>", "bad-substitution", "write true, false, 1 or 0"},
           Wrong{"<group if='1' unless='0'/>", "bad-value", "either 'if' or 'unless'"},
           Wrong{"<arg name='sim' default='2'/>", "duplicate-name", "declared twice"},
           Wrong{"<arg name='needed'/>", "missing-arg", "polyarm run FILE needed:=VALUE"},
           Wrong{"<include file='nowhere.launch'/>", "no-file", "nowhere.launch'"},
           Wrong{"<include/>", "missing-attribute", "write file="},
           Wrong{"<rosparam file='nowhere.yaml'/>", "no-file", "nowhere.yaml'"},
           Wrong{"<rosparam/>", "missing-attribute", "write file="},
           Wrong{"<rosparam command='laod' file='x'/>", "bad-value", "write load"},
           Wrong{"<param name='robot_description' textfile='nowhere.urdf'/>", "no-file", "nowhere.urdf"},
           Wrong{"<param name='robot_description' command='rm -rf x'/>", "foreign-command",
                 "is not run here"},
           Wrong{"<param name='robot_description' command='xacro'/>", "foreign-command", "names no file"},
           Wrong{"<param name='robot_description' command='xacro a b'/>", "foreign-command",
                 "names two files"},
           Wrong{"<node pkg='p' name='n'/>", "missing-attribute", "write type="},
           Wrong{"<node pkg='controller_manager' type='spawner' name='s'/>", "no-controllers",
                 "names no controller"},
           Wrong{"<node pkg='controller_manager' type='spawner' name='s' args='a --timeout'/>", "bad-value",
                 "has no value"},
           Wrong{"<node pkg='controller_manager' type='spawner' name='s' args='a --stoped'/>",
                 "unknown-option", "did you mean '--stopped'?"},
           Wrong{"<inclued file='x'/>", "unknown-element", "did you mean 'include'?"},
       }) {
    const Problem problem =
        only("<launch>\n<arg name='sim' default='1'/>\n\n" + std::string(wrong.line) + "\n</launch>");
    EXPECT_EQ(problem.code, wrong.code) << problem.text();
    EXPECT_EQ(problem.where.line, 4) << problem.text();
    EXPECT_NE(problem.text().find(wrong.says), std::string::npos) << problem.text();
  }
}

TEST_F(LaunchFile, ArgsThatTheFileDoesNotHaveAreRefused) {
  const std::string text =
      "<launch>\n<arg name='sim' default='1'/>\n<arg name='fixed' value='1'/>\n</launch>";
  EXPECT_NE(only(text, {{"sin", "0"}}).text().find("did you mean 'sim'?"), std::string::npos);
  const Problem fixed = only(text, {{"fixed", "0"}});
  EXPECT_EQ(fixed.code, "fixed-arg");
  EXPECT_EQ(fixed.where.line, 3);
}

TEST_F(LaunchFile, WhatFollowsFromAMissingArgIsNotToldAsWell) {
  const Problem problem = only(
      "<launch>\n<arg name='file'/>\n<rosparam file='$(arg file)'/>\n"
      "<group if='$(arg file)'/>\n<include file='$(arg file)'/>\n</launch>");
  EXPECT_EQ(problem.code, "missing-arg");
  const std::string two =
      "<launch>\n<arg name='a' default='$(env POLYARM_NEVER_SET)'/>\n<arg name='b'/>\n"
      "<param name='x' value='$(arg missing)'/></launch>";
  EXPECT_EQ(read(two).problems.list().size(), 2u);
  EXPECT_EQ(read(two, {{"a", "1"}, {"b", "2"}}).problems.list().at(0).code, "unknown-arg");
}

TEST_F(LaunchFile, AGroupMayGiveAnArgAnotherValue) {
  const auto [cell, problems] = read(
      "<launch><arg name='x' value='a'/><group><arg name='x' value='$(arg x)b'/>"
      "<param name='p' value='$(arg x)'/></group><param name='q' value='$(arg x)'/></launch>");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(cell.parameters.at(0).text, "ab");
  EXPECT_EQ(cell.parameters.at(1).text, "a");
}

TEST_F(LaunchFile, AnErrorNamesTheChainOfIncludes) {
  space.write("other/launch/inner.launch", "<launch>\n<param name='x' value='$(arg missing)'/></launch>");
  space.write("other/launch/middle.launch", "<launch>\n\n<include file='inner.launch'/></launch>");
  const Problem problem = only("<launch><include file='$(find other)/launch/middle.launch'/></launch>");
  EXPECT_TRUE(problem.where.text().ends_with("inner.launch:2")) << problem.text();
  const auto middle = problem.what.find("; included from "), main = problem.what.find(", from ");
  ASSERT_NE(middle, std::string::npos) << problem.what;
  ASSERT_NE(main, std::string::npos) << problem.what;
  EXPECT_NE(problem.what.find("middle.launch:3", middle), std::string::npos);
  EXPECT_NE(problem.what.find("main.launch:1", main), std::string::npos);
}

TEST_F(LaunchFile, BrokenXmlInAnIncludedFileIsToldAtItsLine) {
  space.write("other/launch/broken.launch", "<launch>\n<group>\n</launch>");
  const Problem problem = only("<launch>\n<include file='$(find other)/launch/broken.launch'/>\n</launch>");
  EXPECT_EQ(problem.code, "xml-syntax");
  EXPECT_NE(problem.where.text().find("broken.launch:"), std::string::npos);
  EXPECT_GT(problem.where.line, 0);
}

TEST_F(LaunchFile, LoopsOfIncludesEnd) {
  space.write("other/launch/a.launch", "<launch><include file='b.launch'/></launch>");
  space.write("other/launch/b.launch", "<launch>\n<include file='a.launch'/></launch>");
  const Problem plain = only("<launch><include file='$(find other)/launch/a.launch'/></launch>");
  EXPECT_EQ(plain.code, "include-loop");
  EXPECT_TRUE(plain.where.text().ends_with("b.launch:2")) << plain.text();
  space.write("other/launch/grow.launch",
              "<launch><arg name='n'/><include file='grow.launch'><arg name='n' "
              "value='$(eval n + 1)'/></include></launch>");
  EXPECT_EQ(only("<launch><include file='$(find other)/launch/grow.launch'><arg name='n' "
                 "value='0'/></include></launch>")
                .code,
            "include-loop");
  space.write("other/launch/tree.launch",
              "<launch><arg name='n'/><include file='tree.launch'><arg name='n' "
              "value='$(arg n)a'/></include><include file='tree.launch'><arg name='n' "
              "value='$(arg n)b'/></include></launch>");
  EXPECT_NE(thrown("<launch><include file='$(find other)/launch/tree.launch'><arg name='n' "
                   "value='0'/></include></launch>")
                .find("more than 500 launch files"),
            std::string::npos);
}

TEST_F(LaunchFile, RecursionThatEndsIsFollowed) {
  space.write("other/launch/n.launch", R"xml(<launch>
<arg name="n"/>
<param name="p$(arg n)" value="$(arg n)"/>
<include file="n.launch" if="$(eval n > 1)"><arg name="n" value="$(eval n - 1)"/></include>
</launch>)xml");
  const auto [cell, problems] = read(
      "<launch><include file='$(find other)/launch/n.launch'><arg name='n' value='5'/></include></launch>");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(cell.parameters.size(), 5u);
  EXPECT_EQ(cell.parameters[4].ns, "/p1");
}

TEST_F(LaunchFile, OtherFilesAreRefusedWithASentence) {
  EXPECT_NE(thrown("").find("the file is empty"), std::string::npos);
  EXPECT_NE(thrown("<robot name='x'/>").find("it does not begin with <launch>"), std::string::npos);
  EXPECT_NE(thrown("<launch>\n<node pkg='a' exec='b'/></launch>")
                .find("main.launch:2: error: this is a launch file of ROS 2"),
            std::string::npos);
  EXPECT_NE(thrown("<launch><let name='a' value='b'/></launch>").find("ROS 2"), std::string::npos);
  EXPECT_NE(thrown("<launch>\n<arg name='a' default='$(find-pkg-share x)'/></launch>")
                .find("main.launch:2: error: '$(find-pkg-share"),
            std::string::npos);
  EXPECT_THROW(read_file(space / "nowhere.launch"), Error);
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "<group>";
  EXPECT_NE(thrown("<launch>" + deep).find("nested too deep"), std::string::npos);
}

TEST_F(LaunchFile, ParametersWithoutANameAreAnErrorAtTheirLine) {
  const auto [cell, problems] = read("<launch>\n<rosparam>[1, 2]</rosparam>\n</launch>");
  Problems more;
  read_controllers(cell, more);
  ASSERT_EQ(more.list().size(), 1u);
  EXPECT_EQ(more.list()[0].code, "not-parameters");
  EXPECT_EQ(more.list()[0].where.line, 2);
}

TEST_F(LaunchFile, ASpawnerOfAControllerWithoutTypeIsAnError) {
  const auto [cell, problems] = read(R"xml(<launch>
<rosparam>arm_controller: {type: a/B}</rosparam>
<node name="s" pkg="controller_manager" type="spawner" args="arm_controler"/>
<node name="t" pkg="controller_manager" type="spawner" ns="r" args="arm_controller"/>
</launch>)xml");
  Problems more;
  read_controllers(cell, more);
  ASSERT_EQ(more.list().size(), 2u) << all(more);
  EXPECT_EQ(more.list()[0].where.line, 3);
  EXPECT_NE(more.list()[0].what.find("did you mean '/arm_controller'?"), std::string::npos);
  EXPECT_NE(more.list()[1].what.find("there is '/arm_controller', in another namespace"), std::string::npos);
}

// --- anything at all ---

TEST_F(LaunchFile, DamagedFilesEndInAResultOrASentence) {
  const std::string whole = R"xml(<launch>
  <arg name="a" default="1"/>
  <param name="robot_description" command="xacro $(find my_robot)/urdf/robot.xacro p:=$(arg a)"/>
  <group ns="g" if="$(eval a == 1 and not (a > 2 or 'x' in 'xy'))">
    <rosparam param="q">[1, 2]</rosparam>
    <rosparam>c: {type: x/Y, pid: {p: 1}}</rosparam>
    <node name="s" pkg="controller_manager" type="spawner" args="c --stopped --namespace /n"/>
  </group>
  <include file="$(find other)/launch/other.launch" pass_all_args="true"><arg name="b" value="$(arg a)"/></include>
</launch>)xml";
  space.write("other/launch/other.launch",
              "<launch><arg name='b'/><param name='x' value='$(arg b)'/></launch>");
  std::mt19937 random(3);
  int read_well = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    try {
      const auto [cell, problems] = read(test::damaged(whole, kLaunchPieces, 14, random));
      Problems more;
      read_controllers(cell, more);
      ++read_well;
    } catch (const Error& error) {
      EXPECT_FALSE(error.problems().empty());
      ++refused;
    }
  }
  EXPECT_GT(read_well, 500);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace polyarm::ros_files
