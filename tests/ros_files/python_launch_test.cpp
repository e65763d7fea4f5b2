#include "polyarm/launch/python_launch.hpp"

#include <gtest/gtest.h>

#include "polyarm/launch/python_text.hpp"
#include "tests/description/support.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_files::python_launch_test {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

std::filesystem::path packages(const std::string& name) {
  return name == "arm_bringup" ? "/ws/arm_bringup" : "";
}

PythonLaunch read(const std::string& text, const std::map<std::string, std::string>& given = {}) {
  return read_python_launch(text, "/ws/arm_bringup/launch/arm.launch.py", given, packages);
}

bool says(const PythonLaunch& launch, const std::string& piece) {
  for (const auto& [where, what] : launch.not_taken)
    if (what.find(piece) != std::string::npos) return true;
  return false;
}

// The form that the demos and drivers of ROS 2 share.
constexpr const char* kUsual = R"(# a comment with "quotes" and FindPackageShare("none")
from launch import LaunchDescription

def launch_setup(context, *args, **kwargs):
    prefix = LaunchConfiguration("prefix")
    description = Command(
        [
            PathJoinSubstitution([FindExecutable(name="xacro")]), " ",
            PathJoinSubstitution([FindPackageShare("arm_bringup"), "urdf", "arm.urdf.xacro"]),
            " ", "prefix:=", prefix,
            " ", "use_fake_hardware:=", LaunchConfiguration("fake"),
        ]
    )
    controllers = PathJoinSubstitution([FindPackageShare("arm_bringup"), "config", "controllers.yaml"])
    control_node = Node(
        package="controller_manager", executable="ros2_control_node",
        parameters=[{"robot_description": description}, controllers],
    )
    rviz = Node(package="rviz2", parameters=["/no/such.yaml"])
    return [control_node, rviz]

def generate_launch_description():
    declared = []
    declared.append(DeclareLaunchArgument("prefix", default_value='""', description="of names"))
    declared.append(DeclareLaunchArgument("fake", default_value="true"))
    return LaunchDescription(declared + [OpaqueFunction(function=launch_setup)])
)";

TEST(PythonLaunch, ResolvesPathsAndTakesDefaultsThatAreWrittenDown) {
  const PythonLaunch launch = read(kUsual);
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].file, "/ws/arm_bringup/urdf/arm.urdf.xacro");
  EXPECT_EQ(launch.descriptions[0].arguments, (Pairs{{"prefix", ""}, {"use_fake_hardware", "true"}}));
  EXPECT_EQ(launch.descriptions[0].where.line, 6);
  ASSERT_EQ(launch.parameters.size(), 1u) << "rviz's are not the controllers'";
  EXPECT_EQ(launch.parameters[0].file, "/ws/arm_bringup/config/controllers.yaml");
  ASSERT_EQ(launch.arguments.size(), 2u);
  EXPECT_TRUE(launch.not_taken.empty());
  EXPECT_EQ(launch.line(),
            "polyarm run --description /ws/arm_bringup/urdf/arm.urdf.xacro --controllers "
            "/ws/arm_bringup/config/controllers.yaml prefix:= use_fake_hardware:=true");
}

TEST(PythonLaunch, ValuesFromOutsideGoBeforeDefaults) {
  const PythonLaunch launch = read(kUsual, {{"fake", "false"}, {"prefix", "left_"}});
  EXPECT_EQ(launch.descriptions.at(0).arguments,
            (Pairs{{"prefix", "left_"}, {"use_fake_hardware", "false"}}));
  EXPECT_TRUE(launch.arguments.at(0).given);
}

// Functions that launch itself calls get the launch context, and the values that OpaqueFunction names.
TEST(PythonLaunch, FollowsTheValuesThatAnOpaqueFunctionPasses) {
  const PythonLaunch launch = read(R"(
def description_of(context, package, file, fake):
    path = os.path.join(get_package_share_directory(context.perform_substitution(package)), "urdf",
                        perform_substitutions(context, [file]))
    return xacro.process_file(path, mappings={"fake": context.perform_substitution(fake)}).toprettyxml()

def nodes(context: LaunchContext, package, file, fake, controllers):
    text = description_of(context, package, file, fake)
    name = context.perform_substitution(controllers)
    return [Node(package="controller_manager", executable="ros2_control_node",
                 parameters=[{"robot_description": text}, name])]

def spawned(context, hand):
    side = context.launch_configurations["side"]
    other = context.launch_configurations.get("other", "none")
    return [Node(package="controller_manager", executable="spawner",
                 arguments=[side + "_arm", hand + "_" + context.launch_configurations["side"], other])]

def generate_launch_description():
    declared = [DeclareLaunchArgument("package", default_value="arm_bringup"),
                DeclareLaunchArgument("file", default_value="arm.xacro"),
                DeclareLaunchArgument("fake", default_value="true"),
                DeclareLaunchArgument("side", default_value="left")]
    controllers = PathJoinSubstitution([FindPackageShare("arm_bringup"), "config", "two.yaml"])
    return LaunchDescription(declared + [
        OpaqueFunction(function=nodes, args=[LaunchConfiguration("package"), LaunchConfiguration("file"),
                                             LaunchConfiguration("fake"), controllers]),
        TimerAction(period=1.0, actions=[OpaqueFunction(function=spawned, kwargs={"hand": "grip"})])])
)");
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].file, "/ws/arm_bringup/urdf/arm.xacro");
  EXPECT_EQ(launch.descriptions[0].arguments, (Pairs{{"fake", "true"}}));
  ASSERT_EQ(launch.parameters.size(), 1u);
  EXPECT_EQ(launch.parameters[0].file, "/ws/arm_bringup/config/two.yaml");
  EXPECT_EQ(launch.spawned, (std::vector<std::string>{"left_arm", "grip_left", "none"}));
  EXPECT_TRUE(launch.not_taken.empty()) << launch.not_taken.front().second;
}

TEST(PythonLaunch, AnOpaqueFunctionThatIsNotCalledIsNotRead) {
  const PythonLaunch launch = read(R"(
def spawned(context):
    return [Node(package="controller_manager", executable="spawner", arguments=["arm"])]
def other(context):
    return [Node(package="controller_manager", executable="spawner", arguments=["grip"])]
LaunchDescription([OpaqueFunction(function=spawned, condition=IfCondition("false")),
                   OpaqueFunction(function=other, condition=UnlessCondition("false")),
                   OpaqueFunction(function=nowhere, args=[1])])
)");
  EXPECT_EQ(launch.spawned, (std::vector<std::string>{"grip"}));
}

TEST(PythonLaunch, KnowsTheOtherWaysToNameFiles) {
  const auto file = [](const std::string& expression) {
    const PythonLaunch launch =
        read("share = get_package_share_directory('arm_bringup')\nname = 'arm'\nrobot = Command(['xacro ', " +
             expression + "])\n");
    return launch.descriptions.empty() ? std::string("none") : launch.descriptions[0].file.string();
  };
  for (const char* expression :
       {"os.path.join(share, 'urdf', 'arm.xacro')",
        "share + '/urdf/arm.xacro'",
        "f'{share}/urdf/{name}.xacro'",
        "PathSubstitution(FindPackageShare('arm_bringup')) / 'urdf' / 'arm.xacro'",
        "str(Path(share) / 'urdf' / 'arm.xacro')",
        "FindPackageShare(package='arm_bringup').find('arm_bringup'), '/urdf/arm.xacro'",
        "launch_ros.substitutions.FindPackageShare('arm_bringup'), '/urdf', '/arm.xacro'",
        "f\"{get_package_share_directory('arm_bringup')}/urdf/{name}.xacro\"",
        "f'{os.path.join(share, \"urdf\")}/{name!s}.xacro'",
        "'{}/urdf/{}.xacro'.format(share, name)",
        "'{s}/urdf/{0}.xacro'.format('arm', s=share)",
        "'%s/urdf/%s.xacro' % (share, name)",
        "'/'.join([share, 'urdf', 'arm.xacro'])",
        "Path(share).joinpath('urdf', name + '.xacro')",
        "str(Path(share, 'urdf') / f'{name}.xacro')",
        "share + os.sep + 'urdf/arm.xacro'",
        "os.path.join(share, *['urdf', 'arm.xacro'])",
        "(get_package_share_path('arm_bringup') / 'urdf' / 'arm.xacro')",
        "Path('/ws/arm_bringup/launch/a.py').parents[1] / 'urdf' / 'arm.xacro'",
        "share.replace('bringup', 'bringup/urdf') + '/arm.xacro'",
        "\"\"\"/ws/arm_bringup/urdf/arm.xacro\"\"\""})
    EXPECT_EQ(file(expression), "/ws/arm_bringup/urdf/arm.xacro") << expression;
}

TEST(PythonLaunch, TakesTheMappingsOfAFileThatIsProcessed) {
  const PythonLaunch launch = read(
      "x = '/ws/arm.xacro'\n"
      "d = xacro.process_file(x, mappings={'sim': 'true', 'n': str(count())}).toxml()\n");
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].arguments, (Pairs{{"sim", "true"}}));
  EXPECT_TRUE(says(launch, "'n'"));
}

TEST(PythonLaunch, SaysWhatIsComputedAndTakesNoneOfIt) {
  const PythonLaunch computed = read(
      "DeclareLaunchArgument('port')\n"
      "DeclareLaunchArgument('model', default_value=pick_model())\n"
      "a = Command(['xacro ', LaunchConfiguration('model')])\n"
      "b = Command(['xacro ', FindPackageShare('not_here'), '/arm.xacro'])\n"
      "c = Command(['xacro /ws/arm.xacro port:=', LaunchConfiguration('port')])\n"
      "n = Node(package='controller_manager', parameters=[os.path.join(f(), 'c.yaml')])\n");
  ASSERT_EQ(computed.descriptions.size(), 1u);
  EXPECT_TRUE(computed.descriptions[0].arguments.empty());
  EXPECT_TRUE(computed.parameters.empty());
  for (const char* piece :
       {"'port' has no default", "'model' has no default", "description comes from the argument 'model'",
        "not_here", "value of 'port'", "node's parameters is not written down"})
    EXPECT_TRUE(says(computed, piece)) << piece;
  EXPECT_TRUE(read("").line().empty());
}

TEST(PythonLaunch, WhatStandsBetweenTwoComputedPartsIsNoArgument) {
  const PythonLaunch computed = read(
      "n = Node(package='controller_manager', parameters=[os.path.join(f(), 'config', g(), 'c.yaml')])\n");
  EXPECT_TRUE(says(computed, "node's parameters is not written down"));
  EXPECT_FALSE(says(computed, "comes from the argument"));
}

TEST(PythonLaunch, AConditionIsNotTaken) {
  const PythonLaunch launch = read("f = '/a.xacro' if sim else '/b.xacro'\nd = Command(['xacro ', f])\n");
  EXPECT_TRUE(launch.descriptions.empty());
  EXPECT_FALSE(launch.not_taken.empty());
}

TEST(PythonLaunch, VariablesOfParameterFilesGoIntoTheLine) {
  const test::Folder folder;
  const auto yaml = folder.write("c.yaml", "jtc: {ros__parameters: {joints: [$(var prefix)joint_1]}}\n");
  const PythonLaunch launch = read(
      "DeclareLaunchArgument('prefix', default_value='left_')\n"
      "DeclareLaunchArgument('other', default_value='x')\n"
      "d = Command(['xacro /ws/arm.xacro'])\n"
      "n = Node(package='controller_manager', parameters=[ParameterFile('" +
      yaml + "', allow_substs=True)])\n");
  EXPECT_EQ(launch.variables(), (Pairs{{"prefix", "left_"}}));
  EXPECT_NE(launch.line().find(" prefix:=left_"), std::string::npos) << launch.line();
  EXPECT_EQ(launch.line().find("other"), std::string::npos);
}

TEST(PythonLaunch, AFileWithoutParametersIsNoControllersFileInTheLine) {
  const test::Folder folder;
  const auto controllers = folder.write("controllers.yaml", "jtc: {ros__parameters: {joints: [a]}}\n");
  const auto bridge = folder.write("bridge.yaml", "- {ros_topic_name: clock, gz_topic_name: clock}\n");
  const PythonLaunch launch = read(
      "d = Command(['xacro /ws/arm.xacro'])\n"
      "n = Node(package='ros_gz_sim', parameters=['" +
      bridge + "', '" + controllers + "'])\n");
  EXPECT_NE(launch.line().find("controllers.yaml"), std::string::npos) << launch.line();
  EXPECT_EQ(launch.line().find("bridge.yaml"), std::string::npos) << launch.line();
}

/// A package with launch files of its own.
struct Workspace {
  test::Folder folder;
  PackageSearch find = [this](const std::string& name) {
    const auto at = folder.path() / name;
    return std::filesystem::exists(at) ? at : std::filesystem::path();
  };
  PythonLaunch read(const std::string& text, const std::map<std::string, std::string>& given = {}) const {
    const auto file = folder.write("arm_bringup/launch/whole.launch.py", text);
    return read_python_launch(text, file, given, find);
  }
};

TEST(PythonLaunch, FollowsWhatItIncludesWithTheValuesItGives) {
  const Workspace ws;
  ws.folder.write("arm_bringup/launch/rsp.launch.py",
                  "DeclareLaunchArgument('sim', default_value='false')\n"
                  "DeclareLaunchArgument('prefix', default_value='none')\n"
                  "d = Command(['xacro /ws/arm.xacro sim:=', LaunchConfiguration('sim'), ' prefix:=', "
                  "LaunchConfiguration('prefix'), ' outer:=', LaunchConfiguration('outer')])\n");
  const PythonLaunch launch = ws.read(
      "DeclareLaunchArgument('outer', default_value='seen')\n"
      "rsp = IncludeLaunchDescription(PythonLaunchDescriptionSource([os.path.join(\n"
      "    get_package_share_directory('arm_bringup'), 'launch', 'rsp.launch.py')]),\n"
      "    launch_arguments={'sim': 'true', 'prefix': compute()}.items())\n"
      "x = IncludeLaunchDescription(PythonLaunchDescriptionSource(FindPackageShare('nav2_bringup') + "
      "'/n.py'))\n"
      "y = IncludeLaunchDescription(os.path.dirname(__file__) + '/none.launch.py')\n");
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].arguments,
            (Pairs{{"sim", "true"}, {"prefix", "none"}, {"outer", "seen"}}));
  EXPECT_TRUE(launch.descriptions[0].where.file.ends_with("rsp.launch.py"));
  EXPECT_TRUE(says(launch, "in the package 'nav2_bringup', which is not found"));
  EXPECT_EQ(launch.missing_packages, (std::vector<std::string>{"nav2_bringup"}));
  EXPECT_TRUE(says(launch, "none.launch.py' that is included does not exist"));
}

TEST(PythonLaunch, OfWhatItIncludesConditionsThatAreKnownDecide) {
  const Workspace ws;
  ws.folder.write("arm_bringup/launch/sim.launch.py", "d = Command(['xacro /ws/sim.xacro'])\n");
  ws.folder.write("arm_bringup/launch/real.launch.py", "d = Command(['xacro /ws/real.xacro'])\n");
  const std::string text =
      "DeclareLaunchArgument('sim', default_value='true')\n"
      "sim = LaunchConfiguration('sim')\n"
      "IncludeLaunchDescription(ThisLaunchFileDir() + '/sim.launch.py', condition=IfCondition(sim))\n"
      "IncludeLaunchDescription(ThisLaunchFileDir() + '/real.launch.py', condition=UnlessCondition(sim))\n";
  EXPECT_EQ(ws.read(text).descriptions.at(0).file, "/ws/sim.xacro");
  EXPECT_EQ(ws.read(text).descriptions.size(), 1u);
  EXPECT_EQ(ws.read(text, {{"sim", "false"}}).descriptions.at(0).file, "/ws/real.xacro");
}

TEST(PythonLaunch, AFileThatIncludesItselfEnds) {
  const Workspace ws;
  const PythonLaunch launch = ws.read(
      "IncludeLaunchDescription(__file__)\nIncludeLaunchDescription(__file__)\nd = Command(['xacro "
      "/ws/a.xacro'])\n");
  EXPECT_EQ(launch.descriptions.size(), 1u);
  EXPECT_TRUE(says(launch, "too many or too deep"));
}

TEST(PythonLaunch, KnowsTheLayoutOfMoveItsSetupAssistant) {
  const Workspace ws;
  const auto urdf = ws.folder.write("arm_moveit/config/arm.urdf.xacro", "<robot/>");
  const auto other = ws.folder.write("arm_moveit/config/other.urdf.xacro", "<robot/>");
  const auto controllers =
      ws.folder.write("arm_moveit/config/ros2_controllers.yaml", "a: {ros__parameters: {}}\n");
  const PythonLaunch plain = ws.read(
      "c = MoveItConfigsBuilder('arm', package_name='arm_moveit').to_moveit_configs()\n"
      "return generate_demo_launch(c)\n");
  EXPECT_EQ(plain.line(), "polyarm run --description " + urdf + " --controllers " + controllers);
  const PythonLaunch own = ws.read(
      "c = (MoveItConfigsBuilder('arm', package_name='arm_moveit')\n"
      "     .robot_description(file_path='config/other.urdf.xacro', mappings={'sim': 'true'})\n"
      "     .trajectory_execution(file_path='config/x.yaml').to_moveit_configs())\n");
  EXPECT_EQ(own.descriptions.at(0).file, other);
  EXPECT_EQ(own.descriptions.at(0).arguments, (Pairs{{"sim", "true"}}));
}

TEST(PythonLaunch, ReadsDescriptionsThatAreOpenedPublishedOrPrinted) {
  for (const char* text :
       {"with open(os.path.join('/ws', 'arm.urdf'), 'r') as f:\n    d = f.read()\n",
        "doc = xacro.parse(open('/ws/arm.urdf'))\n", "d = Command(['cat ', '/ws/arm.urdf'])\n",
        "n = Node(package='robot_state_publisher', arguments=['/ws/arm.urdf'])\n",
        "files = {'urdf': '/ws/arm.urdf'}\nd = Command(['xacro ', files['urdf']])\n",
        "files = dict(urdf='/ws/arm.urdf')\nd = Command(['xacro ', files.get('urdf')])\n",
        "d = Command(['xacro ', EnvironmentVariable('POLYARM_NOT_SET', default_value='/ws/arm.urdf')])\n",
        "d = (Path('/ws') / 'arm.urdf').read_text()\n",
        "f = '/ws'\nd = xacro.process_file(f\"{f}/arm.urdf\")\n",
        "def load(folder, name):\n    with open(folder + '/' + name) as f:\n        return f.read()\n"
        "d = load('/ws', 'arm.urdf')\n",
        "def path(*, name='arm'):\n    return os.path.join('/ws', name + '.urdf')\nd = Command(['cat ', "
        "path()])\n",
        "with (Path('/ws') / 'arm.urdf').open() as f:\n    d = f.read()\n",
        "a, b = '/ws', 'arm.urdf'\nd = Command(['xacro ', a, '/', b])\n",
        "a: str = '/ws/arm.urdf'\nd = Command(['xacro', ' ', a])\n",
        "a = {}\na['x'] = '/ws/arm.urdf'\nd = Command(['xacro ', a['x']])\n",
        "d = Command(['xacro ', Path('/ws/launch/x.py').parent.parent / 'arm.urdf'])\n"}) {
    const PythonLaunch launch = read(text);
    ASSERT_EQ(launch.descriptions.size(), 1u) << text;
    EXPECT_EQ(launch.descriptions[0].file, "/ws/arm.urdf") << text;
  }
  EXPECT_TRUE(read("d = Command(['xacro /ws/world.sdf.xacro'])\n").descriptions.empty())
      << "SDF is not a robot";
  EXPECT_TRUE(read("d = Command(['xacro /ws/arm.srdf.xacro'])\n").descriptions.empty()) << "SRDF is none";
}

TEST(PythonLaunch, StartsTheControllersThatAreSpawned) {
  const test::Folder folder;
  const auto yaml = folder.write("c.yaml",
                                 "controller_manager: {ros__parameters: {}}\njsb: {ros__parameters: {}}\n"
                                 "arm: {ros__parameters: {}}\ngrip: {ros__parameters: {}}\n");
  const std::string begin =
      "d = Command(['xacro /ws/arm.xacro'])\nn = Node(package='controller_manager', parameters=['" + yaml +
      "'])\n";
  const auto line = [&](const std::string& spawners) { return read(begin + spawners).line(); };
  const std::string spawner = "Node(package='controller_manager', executable='spawner', arguments=";
  EXPECT_TRUE(line(spawner + "['jsb', '--controller-manager', '/controller_manager'])\n" + spawner +
                   "['arm', '-c', '/cm'])\n" + spawner + "['grip', '--inactive'])\n")
                  .ends_with(" --activate arm --activate jsb"));
  EXPECT_TRUE(
      line("ExecuteProcess(cmd=['ros2', 'control', 'load_controller', '--set-state', 'active', 'arm'])\n")
          .ends_with(" --activate arm"));
  for (const char* unknown : {"[LaunchConfiguration('which')])\n", "['arm'], condition=IfCondition(f()))\n",
                              "['somewhere_else'])\n", "names)\n"})
    EXPECT_EQ(line(spawner + "['jsb'])\n" + spawner + unknown).find("--activate"), std::string::npos)
        << unknown;
  EXPECT_EQ(read(begin + spawner + "['jsb'])\n").line("check").find("--activate"), std::string::npos);
}

/// A description and controllers that the launch files below start.
struct Controllers {
  test::Folder folder;
  std::string begin =
      "d = Command(['xacro /ws/arm.xacro'])\nn = Node(package='controller_manager', parameters=['" +
      folder.write("c.yaml",
                   "controller_manager: {ros__parameters: {}}\njsb: {ros__parameters: {}}\n"
                   "arm: {ros__parameters: {}}\ngrip: {ros__parameters: {}}\n") +
      "'])\n";
  std::string activated(const std::string& text) const {
    const std::string line = read(begin + text).line();
    const auto at = line.find(" --activate");
    return at == std::string::npos ? "none" : line.substr(at);
  }
};

TEST(PythonLaunch, SpawnersInLoopsAndComprehensionsAreRead) {
  const Controllers controllers;
  const std::string node = "Node(package='controller_manager', executable='spawner', arguments=[c])";
  for (const std::string& text :
       {"s = [" + node + " for c in ['jsb', 'arm']]\n",
        "s = []\nfor c in ['jsb', 'arm']:\n    s.append(" + node + ")\n",
        "names = ['jsb'] + ['arm']\ns = [" + node + " for c in names]\n",
        "names = []\nnames.append('jsb')\nnames += ['arm']\nfor c in names: " + node + "\n",
        "s = [" + node + " for i, c in enumerate(['jsb', 'arm'])]\n",
        "s = [" + node + " for c, on in [('jsb', True), ('arm', True), ('grip', False)] if on]\n",
        "m = {'jsb': 1, 'arm': 2}\nfor c in m.keys():\n    " + node + "\n",
        "for c, more in {'jsb': [], 'arm': ['x']}.items():\n    " + node + "\n",
        "s = list(" + node + " for c in ('jsb', 'arm'))\n",
        std::string(
            "def spawn(c, *more):\n  return Node(package='controller_manager', executable='spawner', "
            "arguments=[c] + [m for m in more])\nx = [spawn(c) for c in ['jsb', 'arm']]\nspawn('grip', "
            "'--inactive')\n"),
        "def spawn(c, extra=[]):\n    return " + node + "\ns = [spawn('jsb'), spawn(c='arm')]\n",
        "class A:\n  def f(self):\n    for a in ['j', 'x']:\n      if a == 'x': continue\n"
        "for c in ['jsb', 'arm']:\n  if c != 'grip':\n    " +
            node + "\n  else:\n    f(c)\n"})
    EXPECT_EQ(controllers.activated(text), " --activate arm --activate jsb") << text;
}

TEST(PythonLaunch, SpawnersInsideOtherActionsAreRead) {
  const Controllers controllers;
  const std::string node = "Node(package='controller_manager', executable='spawner', arguments=['arm'])";
  for (const std::string& text :
       {"TimerAction(period=3.0, actions=[" + node + "])\n",
        "RegisterEventHandler(event_handler=OnProcessExit(target_action=x, on_exit=[" + node + "]))\n",
        "OpaqueFunction(function=lambda context: [" + node + "])\n",
        "def setup(context, *args):\n    return [" + node + "]\nOpaqueFunction(function=setup)\n",
        "GroupAction(actions=[" + node + "], condition=IfCondition('true'))\n",
        "x = " + node + " if True else f()\n", "x = [*[" + node + "]]\n",
        std::string("ExecuteProcess(cmd=[FindExecutable(name='ros2'), 'control', 'load_controller', "
                    "'--set-state', 'active', 'arm', '-c', '/cm'])\n"),
        std::string(
            "ExecuteProcess(cmd=['ros2 control load_controller --set-state start arm'], shell=True)\n"),
        std::string("ExecuteProcess(cmd=['ros2', 'control', 'set_controller_state', 'arm', 'active'])\n"),
        std::string("ExecuteProcess(cmd=['ros2', 'control', 'switch_controllers', '--activate', 'arm', "
                    "'--deactivate', 'grip'])\n"),
        std::string("ExecuteProcess(cmd=['ros2', 'run', 'controller_manager', 'spawner', 'arm'])\n")})
    EXPECT_EQ(controllers.activated(text), " --activate arm") << text;
}

TEST(PythonLaunch, ConditionsThatAreKnownDecideAboutSpawners) {
  const Controllers controllers;
  const std::string node = "Node(package='controller_manager', executable='spawner', arguments=['arm'])\n";
  const std::string arm = "Node(package='controller_manager', executable='spawner', arguments=['jsb'])\n" +
                          std::string("DeclareLaunchArgument('sim', default_value='true')\n") +
                          "sim = LaunchConfiguration('sim').perform(context)\n";
  EXPECT_EQ(controllers.activated(arm + "if sim == 'true':\n  " + node), " --activate arm --activate jsb");
  EXPECT_EQ(controllers.activated(arm + "if sim.lower() != 'true':\n  " + node), " --activate jsb");
  EXPECT_EQ(controllers.activated(arm + "if sim in ('no', 'false'):\n  " + node + "else:\n  pass\n"),
            " --activate jsb");
  EXPECT_EQ(
      controllers.activated(arm + "GroupAction(condition=UnlessCondition(sim), actions=[" + node + "])\n"),
      " --activate jsb");
  EXPECT_EQ(controllers.activated(arm + "x = None if sim == 'true' else " + node), " --activate jsb");
}

TEST(PythonLaunch, SpawnersThatCannotBeReadAreSaidWithTheirLine) {
  const Controllers controllers;
  const std::string node = "Node(package='controller_manager', executable='spawner', arguments=[c])";
  for (const std::string& text :
       {"s = [" + node + " for c in names()]\n", "for c in names():\n    " + node + "\n",
        "if f():\n    c = 'arm'\n    " + node + "\n", "c = 'arm'\nx = " + node + " if f() else None\n",
        "c = 'arm'\nGroupAction([" + node + "], condition=IfCondition(f()))\n",
        "c = 'arm'\nx = y or " + node + "\n", "while f():\n    " + node + "\n",
        std::string(
            "ExecuteProcess(cmd=['ros2', 'control', 'load_controller', '--set-state', 'active', f()])\n")}) {
    const PythonLaunch launch = read(controllers.begin + text);
    EXPECT_EQ(controllers.activated(text), "none") << text;
    EXPECT_FALSE(launch.why_no_activate().empty()) << text;
    ASSERT_EQ(launch.not_taken.size(), 1u) << text;
    EXPECT_GE(launch.not_taken[0].first.line, 3) << text;
    EXPECT_TRUE(says(launch, "started")) << text;
  }
}

TEST(PythonLaunch, AControllerThatNoFileHasIsSaid) {
  const Controllers controllers;
  const PythonLaunch launch = read(
      controllers.begin + "Node(package='controller_manager', executable='spawner', arguments=['other'])\n");
  EXPECT_NE(launch.why_no_activate().find("'other'"), std::string::npos);
}

TEST(PythonLaunch, WhatTheDescriptionNeedsAndNobodySaysIsToBeFilledIn) {
  const test::Folder folder;
  const auto xacro = folder.write("a.xacro",
                                  "<robot><xacro:arg name=\"model\"/><xacro:arg name=\"sim\" "
                                  "default=\"true\"/></robot>");
  const PythonLaunch launch =
      read("DeclareLaunchArgument('model', choices=['one', 'two'])\nd = Command(['xacro ', '" + xacro +
           "', ' model:=', LaunchConfiguration('model'), ' sim:=', f()])\n");
  EXPECT_EQ(launch.needed(), (std::vector<PythonLaunchNeed>{{"model", "model"}}));
  EXPECT_TRUE(launch.line().ends_with(" model:=VALUE")) << launch.line();
  EXPECT_TRUE(says(launch, "it is one of one, two"));
}

TEST(PythonLaunch, OfALaunchFileWithoutADescriptionItsPackageIsLookedThrough) {
  const test::Folder folder;
  folder.write("ws/arm_bringup/package.xml", "<package><name>arm_bringup</name></package>");
  const auto launch = folder.write("ws/arm_bringup/launch/joy.launch.py", "");
  folder.write("ws/arm_description/package.xml", "<package><name>arm_description</name></package>");
  folder.write("ws/arm_description/urdf/arm.urdf.xacro",
               "<robot name=\"a\"><xacro:include filename=\"part.xacro\"/></robot>");
  folder.write("ws/arm_description/urdf/part.xacro", "<robot/>");
  folder.write("ws/arm_bringup/config/c.yaml", "controller_manager: {ros__parameters: {}}\n");
  folder.write("ws/arm_bringup/config/other.yaml", "rviz: 1\n");
  const std::vector<std::string> lines = lines_of_package(launch, "run");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("arm_description/urdf/arm.urdf.xacro"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find(" --controllers "), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("/c.yaml"), std::string::npos) << lines[0];
  EXPECT_TRUE(lines_of_package("/nowhere/launch.py", "run").empty());
}

TEST(PythonLaunch, FilesThatAreNoRobotAreNotOffered) {
  const test::Folder folder;
  folder.write("ws/arm/package.xml", "<package><name>arm</name></package>");
  const auto launch = folder.write("ws/arm/launch/joy.launch.py", "");
  folder.write("ws/arm/config/arm.srdf.xacro", "<robot name=\"a\"><group name=\"g\"/></robot>");
  folder.write("ws/arm/urdf/wheel.urdf.xacro",
               "<robot><xacro:include filename=\"x.xacro\"/><xacro:property name=\"r\" value=\"1\"/>"
               "<xacro:macro name=\"wheel\" params=\"p\"><link name=\"${p}\"/><xacro:macro name=\"inner\">"
               "</xacro:macro><xacro:rim/></xacro:macro> <!-- <link/> <xacro:wheel/> --></robot>");
  folder.write("ws/arm/urdf/arm.materials.xacro",
               "<robot><material name=\"red\"><color/></material></robot>");
  EXPECT_TRUE(lines_of_package(launch, "run").empty());
  folder.write("ws/arm/urdf/called.urdf.xacro",
               "<robot><xacro:macro name=\"arm\"><link name=\"a\"/></xacro:macro><xacro:arm/></robot>");
  folder.write("ws/arm/urdf/linked.urdf.xacro",
               "<robot><xacro:macro name=\"arm\"></xacro:macro><link name=\"a\"/></robot>");
  folder.write("ws/arm/urdf/whole.urdf.xacro", "<robot><xacro:include filename=\"parts.xacro\"/></robot>");
  EXPECT_EQ(lines_of_package(launch, "run").size(), 3u);
}

TEST(PythonLaunch, RobotsOfOtherPackagesOfAWorkspaceAreNotOffered) {
  const test::Folder folder;
  folder.write("ws/arm_bringup/package.xml",
               "<package><name>arm_bringup</name><exec_depend>cell_parts</exec_depend></package>");
  const auto launch = folder.write("ws/arm_bringup/launch/joy.launch.py", "");
  const std::string robot = "<robot name=\"r\"><link name=\"a\"/></robot>";
  for (const char* name : {"arm_description", "cell_parts", "a_rover"}) {
    const std::string package = "ws/" + std::string(name);
    folder.write(package + "/package.xml", "<package><name>" + std::string(name) + "</name></package>");
    folder.write(package + "/urdf/" + name + ".urdf", robot);
  }
  folder.write("ws/a_rover/config/c.yaml", "controller_manager:\n  ros__parameters: {}\n");
  folder.write("ws/arm_description/urdf/numbers.xacro",
               "<robot><xacro:property name=\"deg\" value=\"0.0174\"/></robot>");
  std::string lines;
  for (const std::string& line : lines_of_package(launch, "run")) lines += line + "\n";
  EXPECT_NE(lines.find("arm_description.urdf"), std::string::npos) << lines;
  EXPECT_NE(lines.find("cell_parts.urdf"), std::string::npos) << lines;
  EXPECT_EQ(lines.find("a_rover"), std::string::npos) << lines;
  EXPECT_EQ(lines.find("numbers"), std::string::npos) << lines;
}

TEST(PythonLaunch, OddWordsAreQuotedInTheLine) {
  const PythonLaunch launch = read("d = Command(['xacro /ws/arm.xacro a:=\"$(rm -rf)\"'])\n");
  EXPECT_NE(launch.line().find("'a:=$(rm -rf)'"), std::string::npos) << launch.line();
}

TEST(PythonLaunch, QuotedArgumentsOfACommandKeepTheirBlanks) {
  const PythonLaunch launch = read(
      "d = Command(['xacro ', '/ws/a.urdf.xacro', ' left_xyz:=\"', LaunchConfiguration('xyz'), '\"', "
      "\" right_rpy:='0 0 1.57'\", ' prefix:=\"\" sim:=true'])\n",
      {{"xyz", "0 0.5 1"}});
  EXPECT_EQ(launch.descriptions.at(0).arguments,
            (Pairs{{"left_xyz", "0 0.5 1"}, {"right_rpy", "0 0 1.57"}, {"prefix", ""}, {"sim", "true"}}));
}

TEST(PythonLaunch, AnExpressionThatIsWrittenDownIsEvaluated) {
  const std::string text =
      "sim = LaunchConfiguration('sim', default='true')\n"
      "Node(package='controller_manager', executable='spawner', arguments=['a'], "
      "condition=IfCondition(PythonExpression(['\"', sim, '\" not in [\"false\", \"no\"]'])))\n";
  EXPECT_EQ(read(text).spawned, (std::vector<std::string>{"a"}));
  EXPECT_TRUE(read(text).spawned_known);
  EXPECT_TRUE(read(text, {{"sim", "no"}}).spawned.empty());
  EXPECT_FALSE(
      read("x = IfCondition(PythonExpression([LaunchConfiguration('y'), ' == 1']))\n"
           "Node(package='controller_manager', executable='spawner', arguments=['a'], condition=x)\n")
          .spawned_known);
}

TEST(PythonText, IsCutIntoWords) {
  std::vector<std::string> words;
  for (const PythonToken& token : python_tokens("a = f\"x{b}\" # c\n'''d\ne''' == 1.5\n"))
    words.push_back(token.text);
  EXPECT_EQ(words, (std::vector<std::string>{"a", "=", "x{b}", "d\ne", "==", "1.5"}));
  EXPECT_EQ(python_tokens("\n\nx").at(0).line, 3);
  EXPECT_TRUE(python_tokens("'does not end\n").empty());
}

TEST(PythonLaunchFuzz, AnythingEndsInTime) {
  read(std::string(1 << 21, '('));
  read(std::string(1 << 20, '['));
  std::string deep, calls;
  for (int i = 0; i < 20'000; ++i) deep += "\"a\".f(", calls += "f([{'a': ";
  read(deep);
  read(calls);
  for (const char* begin : {"a = 'x'\n", "a = ['x']\n", "a = {'x': 'y'}\n"})
    for (const char* doubled : {"a = a + a\n", "a = [a, a]\n", "a = (a, [a], {'b': a})\n"}) {
      std::string text = begin;
      for (int i = 0; i < 4000; ++i) text += doubled;
      read(text + "d = Command(a)\n");
    }
  description::test::Mutator mutate(5);
  for (int i = 0; i < 2000; ++i) read(mutate(kUsual));
}

}  // namespace
}  // namespace polyarm::ros_files::python_launch_test
