#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <thread>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::run_command;
namespace fs = std::filesystem;

TEST(R6bot, FollowsItsReferenceUnderItsOwnControllerAndItsOwnSystem) {
  const test::ExampleCopy copy("r6bot");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_NE(ran.output.find("ros2_control_demo_example_7/RobotSystem"), std::string::npos);
  EXPECT_GT(ran.result()["sim_time_s"].get<double>(), 3.0) << "the curve takes three seconds";
  EXPECT_EQ(run_command({"run", copy.path(), "--fast", "--json"}).result()["trace_hash"],
            ran.result()["trace_hash"]);
}

TEST(R6bot, OneLineExchangesTheController) {
  const test::ExampleCopy copy("r6bot");
  std::string yaml = read_file(copy.file("r6bot_controllers.yaml"));
  const std::string own = "type: ros2_control_demo_example_7/RobotController";
  yaml.replace(yaml.find(own), own.size(), "type: joint_trajectory_controller/JointTrajectoryController");
  write_file_atomically(copy.file("r6bot_controllers.yaml"), yaml);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_GT(ran.result()["sim_time_s"].get<double>(), 3.0);
}

TEST(ThreeJoint, RunsFromItsLaunchFile) {
  const test::ExampleCopy copy("three_joint");
  const Finished ran = run_command(
      {"run", copy.path() + "/three_joint.launch", "--fast", "--seconds", "1", "--json"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_NE(ran.output.find("not applicable here: 'MyRobotHardwareInterface'"), std::string::npos)
      << ran.output;
  EXPECT_NE(ran.output.find("'pid' has no effect"), std::string::npos) << ran.output;
}

TEST(ThreeJoint, RunsInPhysicsUnderPids) {
  const test::ExampleCopy copy("three_joint");
  const Finished ran = run_command({"run", copy.path() + "/pid.yaml", "--hardware", "mock", "--fast",
                                    "--seconds", "1", "--json"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(RunningCell, IsAskedAndToldFromOutside) {
  const fs::path folder = fs::temp_directory_path() / ("polyarm_door_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  const test::ExampleCopy copy("three_joint");
  test::Command cell({"run", copy.path() + "/three_joint.launch", "--seconds", "60", "--quiet"});
  nlohmann::json listed;
  for (int k = 0; k < 200 && !listed.is_array(); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const Finished asked = run_command({"control", "list", "--json"});
    if (asked.exit_code == 0) listed = nlohmann::json::parse(asked.output, nullptr, false);
  }
  ASSERT_TRUE(listed.is_array());
  EXPECT_EQ(listed.size(), 4u);
  EXPECT_EQ(run_command({"send", "/MyRobot/JointC_PositionController/command", "{data: 0.9}"}).exit_code, 0);
  const Finished dry = run_command({"control", "switch", "-d", "JointC_PositionController", "--dry"});
  EXPECT_NE(dry.output.find("would stop JointC_PositionController"), std::string::npos) << dry.output;
  EXPECT_EQ(run_command({"control", "state", "JointC_PositionController", "inactive"}).exit_code, 0);
  EXPECT_NE(run_command({"hardware", "list"}).output.find("MyRobotHardware"), std::string::npos);
  const Finished watched = run_command({"watch", "joint_states", "--count", "1", "--json"});
  EXPECT_NE(watched.output.find("JointC"), std::string::npos) << watched.output;
  const Finished wrong = run_command({"send", "JointD", "{data: 1}"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.output.find("JointA_EffortController"), std::string::npos) << wrong.output;
  cell.signal(SIGINT);
  EXPECT_EQ(cell.wait().exit_code, 3);
  ::unsetenv("XDG_RUNTIME_DIR");
  fs::remove_all(folder);
}

TEST(RunningCell, WithoutOneThereIsASentence) {
  ::setenv("XDG_RUNTIME_DIR", "/nonexistent", 1);
  const Finished asked = run_command({"control", "list"});
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_NE(asked.output.find("no cell is running"), std::string::npos) << asked.output;
}

}  // namespace
}  // namespace polyarm
