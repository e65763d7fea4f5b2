/// `polyarm plugin build`: a package in ROS's style, its hardware and its controller, built without ROS, in a cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "polyarm/base/error.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;

/// A copy of tests/ros_packages/two_joints, and a home for what is built and approved.
struct Workshop : testing::Test {
  test::Folder place;
  std::string package = (place.path() / "ws/two_joints").string();
  void SetUp() override {
    fs::create_directories(place.path() / "ws");
    fs::copy(fs::path(POLYARM_SOURCE_DIR) / "tests/ros_packages/two_joints", package,
             fs::copy_options::recursive);
    ::setenv("XDG_CONFIG_HOME", (place.path() / "config").c_str(), 1);
    ::setenv("XDG_DATA_HOME", (place.path() / "data").c_str(), 1);
    ::setenv("XDG_CACHE_HOME", (place.path() / "cache").c_str(), 1);
    ::setenv("CMAKE_BUILD_TYPE", "None", 1);
  }
  test::Finished run(const std::string& robot, std::vector<std::string> more = {}) {
    place.write("cell/cell.yaml",
                "polyarm: cell/1\nrate: 100\ncontrollers: controllers.yaml\n"
                "robots: {arm: {model: robot.urdf, hardware: declared}}\nsend: {joint_trajectory_controller: "
                "move.yaml}\n");
    place.write("cell/robot.urdf", robot);
    place.write("cell/controllers.yaml", read_file(package + "/controllers.yaml"));
    place.write("cell/move.yaml", read_file(fs::path(POLYARM_SOURCE_DIR) / "templates/hardware/move.yaml"));
    std::vector<std::string> words{"run", (place.path() / "cell").string(), "--fast", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_command(words);
  }
};

TEST_F(Workshop, BuildsAPackageAndRunsItsHardwareInACell) {
  // A library of ROS 1 that uses nothing of ROS lies beside it.
  place.write("ws/springs/package.xml",
              "<package><name>springs</name><buildtool_depend>catkin</buildtool_depend></package>");
  place.write("ws/springs/CMakeLists.txt",
              "cmake_minimum_required(VERSION 3.5)\nproject(springs)\nfind_package(catkin REQUIRED)\n"
              "catkin_package(INCLUDE_DIRS include LIBRARIES springs)\nadd_library(springs src/springs.cpp)\n"
              "target_include_directories(springs PUBLIC include)\n");
  place.write("ws/springs/include/springs/springs.h", "int springs();\n");
  place.write("ws/springs/src/springs.cpp", "#include <springs/springs.h>\nint springs() { return 2; }\n");
  place.write("ws/two_joints/src/age.cpp",
              "#include \"age.hpp\"\n#include <springs/springs.h>\nint count() { return springs(); }\n");
  std::string build_file = read_file(package + "/CMakeLists.txt");
  build_file.replace(build_file.find("realtime_tools std_msgs"), 14, "realtime_tools springs");
  place.write("ws/two_joints/CMakeLists.txt", build_file);

  const auto built = test::run_command({"plugin", "build", package, "--simulated"});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  EXPECT_NE(built.output.find("<plugin>two_joints/TwoJoints</plugin>"), std::string::npos) << built.output;
  EXPECT_NE(built.output.find("type: two_joints/Scale"), std::string::npos) << built.output;
  EXPECT_FALSE(fs::exists(package + "/build"));  // nothing is written into the source

  const std::string robot = read_file(package + "/robot.urdf");
  const auto done = run(robot);
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("two joints are active"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("two_joints/TwoJoints, a ros2_control plugin"), std::string::npos)
      << done.output;

  // The package's controller is a type of its own; what is sent to it moves the joints.
  place.write("cell/controllers.yaml",
              "controller_manager: {ros__parameters: {scale: {type: two_joints/Scale}}}\n"
              "scale: {ros__parameters: {joints: [joint_1, joint_2], gain: 0.5}}\n");
  place.write("cell/numbers.yaml", "{data: [0.8, -0.4]}\n");
  place.write("cell/cell.yaml",
              "polyarm: cell/1\nrate: 100\ncontrollers: controllers.yaml\n"
              "robots: {arm: {model: robot.urdf, hardware: declared}}\nsend: {scale: numbers.yaml}\n");
  const auto scaled =
      test::run_command({"run", (place.path() / "cell").string(), "--fast", "--json", "--seconds", "2"});
  EXPECT_EQ(scaled.exit_code, 0) << scaled.output;
  EXPECT_NE(scaled.output.find("[scale]: scales by 0.50"), std::string::npos) << scaled.output;

  // What it throws in a cycle is a fault with its words.
  std::string faulty = robot;
  faulty.replace(faulty.find("<plugin>"), 0, "<param name=\"throw_at\">50</param>");
  const auto fault = run(faulty);
  EXPECT_NE(fault.exit_code, 0) << fault.output;
  EXPECT_NE(fault.output.find("the cable of two joints is cut"), std::string::npos) << fault.output;

  // A module that changed since is not opened.
  const fs::path module = place.path() / "data/polyarm/plugins/two_joints.so";
  write_file_atomically(module, read_file(module) + "x");
  const auto changed = run(robot);
  EXPECT_NE(changed.exit_code, 0) << changed.output;
  EXPECT_NE(changed.output.find("has changed since it was built"), std::string::npos) << changed.output;
}

/// A workspace whose packages are not as tidy as those above: see tests/ros_packages/one_joint_ws.
TEST_F(Workshop, BuildsWhatPackagesLeaveToTheirNeighbours) {
  const std::string workspace = (place.path() / "one").string();
  fs::copy(fs::path(POLYARM_SOURCE_DIR) / "tests/ros_packages/one_joint_ws", workspace,
           fs::copy_options::recursive);
  const auto checked = test::run_command({"plugin", "check", workspace});
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  const auto built = test::run_command({"plugin", "build", workspace, "--simulated"});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  EXPECT_NE(built.output.find("one_joint.so"), std::string::npos) << built.output;
  EXPECT_NE(built.output.find("it exports no class one_joint::Gone"), std::string::npos) << built.output;
  EXPECT_EQ(built.output.find("<plugin>one_joint/Gone"), std::string::npos) << built.output;
  const auto list = test::run_command({"plugin", "list"});
  EXPECT_NE(list.output.find("one_joint/OneJoint"), std::string::npos) << list.output;
  EXPECT_EQ(list.output.find("one_joint/Gone"), std::string::npos) << list.output;

  std::string robot = read_file(package + "/robot.urdf");
  robot.replace(robot.find("two_joints/TwoJoints"), 20, "one_joint/OneJoint");
  const auto second = robot.rfind("<joint name=\"joint_2\">");
  robot.erase(second, robot.find("</joint>", second) + 8 - second);
  place.write("cell/cell.yaml",
              "polyarm: cell/1\nrate: 100\nrobots: {arm: {model: robot.urdf, hardware: declared}}\n");
  place.write("cell/robot.urdf", robot);
  const auto done =
      test::run_command({"run", (place.path() / "cell").string(), "--fast", "--json", "--seconds", "1"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("the note says 1.500000 at tick 12"), std::string::npos) << done.output;
}

TEST_F(Workshop, BuildsWhatIsCommonToAllPackagesOnceAndTheInterfaceOfFoxy) {
  const std::string early = (place.path() / "early_joint").string();
  fs::copy(fs::path(POLYARM_SOURCE_DIR) / "tests/ros_packages/early_joint", early,
           fs::copy_options::recursive);
  // Of those that earlier releases and killed builds left, the young ones may belong to another build.
  const fs::path shared = place.path() / "cache/polyarm/plugins/wrappers";
  for (int i = 0; i < 17; ++i) {
    const std::string name = "old" + std::to_string(i) + (i % 2 ? ".o" : ".tmp");
    place.write("cache/polyarm/plugins/wrappers/" + name, "");
    fs::last_write_time(shared / name, fs::file_time_type::clock::now() - std::chrono::hours(2));
  }
  place.write("cache/polyarm/plugins/wrappers/young.tmp", "");
  const auto wrappers = [&] {
    std::map<std::string, fs::file_time_type> out;
    for (const auto& file : fs::directory_iterator(shared))
      out[file.path().filename().string()] = file.last_write_time();
    return out;
  };
  const auto built = test::run_command({"plugin", "build", early, "--simulated"});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  const auto first = wrappers();
  EXPECT_EQ(first.size(), 2u);  // the wrapper, and the young one
  EXPECT_TRUE(first.contains("young.tmp"));
  const auto rebuilt = test::run_command({"plugin", "build", early, "--simulated"});
  ASSERT_EQ(rebuilt.exit_code, 0) << rebuilt.output;
  EXPECT_EQ(wrappers(), first);

  std::string robot = read_file(package + "/robot.urdf");
  robot.replace(robot.find("two_joints/TwoJoints"), 20, "early_joint/EarlyJoint");
  const auto second = robot.rfind("<joint name=\"joint_2\">");
  robot.erase(second, robot.find("</joint>", second) + 8 - second);
  place.write("cell/cell.yaml",
              "polyarm: cell/1\nrate: 100\nrobots: {arm: {model: robot.urdf, hardware: declared}}\n");
  place.write("cell/robot.urdf", robot);
  const auto done =
      test::run_command({"run", (place.path() / "cell").string(), "--fast", "--json", "--seconds", "1"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("joint_1 has started"), std::string::npos) << done.output;

  // Another package of the same kind takes what is there.
  const std::string other = (place.path() / "other").string();
  fs::copy(early, other, fs::copy_options::recursive);
  for (const char* name : {"package.xml", "CMakeLists.txt", "early_joint.xml"}) {
    std::string text = read_file(other + "/" + name);
    for (auto at = text.find("early_joint"); at != std::string::npos; at = text.find("early_joint", at + 11))
      if (text.compare(at, 13, "early_joint::") != 0 && text.compare(at, 15, "early_joint.cpp") != 0 &&
          text.compare(at, 15, "early_joint.xml") != 0)
        text.replace(at, 11, "later_joint");
    place.write("other/" + std::string(name), text);
  }
  const auto again = test::run_command({"plugin", "build", other, "--simulated"});
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_NE(again.output.find("later_joint/EarlyJoint"), std::string::npos) << again.output;
  EXPECT_EQ(wrappers(), first);
}

/// True while the process exists and is no zombie.
bool lives(int pid) {
  std::error_code error;
  const std::string stat = "/proc/" + std::to_string(pid) + "/stat";
  if (!fs::exists(stat, error)) return false;
  const std::string text = read_file(stat);
  return text.find(") Z") == std::string::npos;
}

TEST_F(Workshop, ABuildThatIsKilledTakesItsCompilersWithIt) {
  const std::string note = (place.path() / "compiler").string();
  place.write("bin/cmake", "#!/bin/sh\nsleep 1000 &\necho $! > " + note + ".new\nmv " + note + ".new " + note +
                               "\nwait\n");
  fs::permissions(place.path() / "bin/cmake", fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", ((place.path() / "bin").string() + ":" + path).c_str(), 1);
  test::Command build({"plugin", "build", package});
  ::setenv("PATH", path.c_str(), 1);
  while (!fs::exists(note)) ASSERT_FALSE(build.ends_unread(1)) << "the build has ended";
  const int compiler = std::stoi(read_file(note));
  EXPECT_TRUE(lives(compiler));
  build.signal(SIGKILL);
  build.wait();
  while (lives(compiler)) ::usleep(10'000);
}

TEST_F(Workshop, SourcesOfRosInTheWorkspaceAreNotTakenForItsHeaders) {
  place.write("ws/hardware_interface/package.xml",
              "<package><name>hardware_interface</name><export><build_type>ament_cmake</build_type></"
              "export></package>");
  place.write("ws/hardware_interface/CMakeLists.txt", "message(FATAL_ERROR \"needs the rest of ROS\")\n");
  place.write("ws/hardware_interface/include/hardware_interface/system_interface.hpp",
              "#include <rcl/all_of_it.h>\n");
  for (const std::string& path : {package, (place.path() / "ws").string()}) {
    const auto checked = test::run_command({"plugin", "check", path});
    EXPECT_EQ(checked.exit_code, 0) << checked.output;
    EXPECT_NE(checked.output.find("two_joints: nothing is missing"), std::string::npos) << checked.output;
  }
}

TEST_F(Workshop, AnInterfaceThatPolyarmHasIsNotMadeTwice) {
  place.write("std_msgs/msg/Bool.msg", "bool data\n");
  place.write("std_msgs/msg/Trit.msg", "int8 data\n");
  const std::string out = (place.path() / "out").string();
  const auto made = test::run_command({"plugin", "interfaces", "--package", "std_msgs", "--out", out,
                                       (place.path() / "std_msgs/msg/Bool.msg").string(),
                                       (place.path() / "std_msgs/msg/Trit.msg").string()});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  EXPECT_TRUE(fs::exists(out + "/std_msgs/msg/trit.hpp"));
  EXPECT_FALSE(fs::exists(out + "/std_msgs/msg/bool.hpp"));
}

TEST_F(Workshop, SaysWhatIsMissingInsteadOfTheCompilersPages) {
  const std::string source = package + "/src/two_joints.cpp";
  write_file_atomically(source, "#include <serial/serial.h>\n" + read_file(source));
  const auto checked = test::run_command({"plugin", "check", package});
  EXPECT_EQ(checked.exit_code, 1) << checked.output;
  EXPECT_NE(checked.output.find("two_joints.cpp:1: error: no header 'serial/serial.h' is here"),
            std::string::npos)
      << checked.output;
  const auto built = test::run_command({"plugin", "build", package});
  EXPECT_EQ(built.exit_code, 1) << built.output;
  EXPECT_NE(built.output.find("two_joints.cpp:1: error: no header 'serial/serial.h' is here"),
            std::string::npos)
      << built.output;
  EXPECT_LT(std::count(built.output.begin(), built.output.end(), '\n'), 8) << built.output;
}

}  // namespace
}  // namespace polyarm
