#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <functional>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using nlohmann::json;
using test::Command;
using test::Finished;
using test::run_command;
namespace fs = std::filesystem;

TEST(JetBot, RunsWithoutLinksAndSaysSo) {
  const test::ExampleCopy copy("jetbot");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--seconds", "2", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["control_cycles"], 20) << "10 Hz";
  EXPECT_NE(ran.output.find("jetbot_control/JetBotSystemHardware is simulated by mock"), std::string::npos);
  EXPECT_NE(ran.output.find("the description has no links"), std::string::npos) << ran.output;
}

TEST(JetBot, MockIsChosenByItsArgument) {
  const test::ExampleCopy copy("jetbot");
  const Finished ran =
      run_command({"run", copy.path(), "use_mock_hardware:=true", "--fast", "--seconds", "1", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_NE(ran.output.find("mock_components/GenericSystem is simulated by mock"), std::string::npos);
  EXPECT_EQ(ran.output.find("JetBotSystemHardware"), std::string::npos);
}

TEST(JetBot, PrefixesReachItsJoints) {
  const test::ExampleCopy copy("jetbot");
  for (const char* file : {"/urdf/jetbot.urdf.xacro", "/urdf/jetbot_body.urdf.xacro"}) {
    const Finished urdf = run_command({"xacro", copy.path() + file, "prefix:=front_"});
    EXPECT_EQ(urdf.exit_code, 0) << urdf.output;
    EXPECT_NE(urdf.output.find("<joint name=\"front_right_wheel_joint\""), std::string::npos) << urdf.output;
    EXPECT_EQ(urdf.output.find("\"right_wheel_joint"), std::string::npos);
  }
}

TEST(JetBot, OnTheRobotItSaysWhichBusIsMissing) {
  const test::ExampleCopy copy("jetbot");
  std::string cell = read_file(copy.file("cell.yaml"));
  const std::string declared = "hardware: declared}";
  cell.replace(cell.find(declared), declared.size(),
               "hardware: pca9685, parameters: {bus: /nonexistent/i2c-9}}");
  write_file_atomically(copy.file("cell.yaml"), cell);
  const Finished ran = run_command({"run", copy.path(), "--real", "--seconds", "1"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("/nonexistent/i2c-9 cannot be opened"), std::string::npos) << ran.output;
}

/// A cell on the wall clock, and a twist that is sent to it all the time.
class DrivenJetBot : public ::testing::Test {
 protected:
  DrivenJetBot() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_jetbot_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  }
  ~DrivenJetBot() override {
    ::unsetenv("XDG_RUNTIME_DIR");
    fs::remove_all(folder);
  }
  static json asked(std::vector<std::string> line) {
    line.push_back("--json");
    const Finished finished = run_command(line);
    return finished.exit_code == 0 ? json::parse(finished.output, nullptr, false) : json();
  }
  static double state(const std::string& name) {
    const json all = asked({"interfaces"});
    if (!all.is_object()) return NAN;
    for (const json& s : all["states"])
      if (s["name"] == name) return s["value"].is_number() ? s["value"].get<double>() : NAN;
    return NAN;
  }
  /// Asks again and again, each time a process; a generous number of times.
  static bool comes_true(const std::function<bool()>& claim) {
    for (int tries = 0; tries < 5000; ++tries)
      if (claim()) return true;
    return false;
  }
  static bool up() {
    return comes_true([] { return run_command({"health"}).exit_code == 0; });
  }
  static json odometry() { return run_command({"watch", "odom", "--count", "1", "--json"}).result(); }
  fs::path folder;
  const test::ExampleCopy copy{"jetbot"};
};

TEST_F(DrivenJetBot, DrivesOnTheMockAndTellsItsOdometry) {
  Command cell({"run", copy.path(), "use_mock_hardware:=true", "--quiet"});
  ASSERT_TRUE(up());
  Command twist({"send", "/jetbot_base_controller/cmd_vel", "{linear: {x: 0.01}}", "--rate", "20"});
  EXPECT_TRUE(comes_true([] { return state("jetbot/left_wheel_joint/velocity") > 0.3; }))
      << "0.01 m/s / 32 mm";
  EXPECT_TRUE(comes_true([] { return odometry()["pose"]["pose"]["position"]["x"].get<double>() > 0.005; }));
  EXPECT_NE(run_command({"watch", "odom", "--count", "1"}).output.find("position"), std::string::npos);
  twist.signal(SIGINT);
  twist.wait();
  EXPECT_TRUE(comes_true([] { return state("jetbot/left_wheel_joint/velocity") == 0; })) << "cmd_vel_timeout";
}

TEST_F(DrivenJetBot, DrivesInPhysics) {
  Command cell({"run", copy.path() + "/driving.yaml", "--json"});
  ASSERT_TRUE(cell.wait_for("JetBot"));
  ASSERT_TRUE(up());
  if (!std::isfinite(state("jetbot/base/position.x"))) GTEST_SKIP() << "physics is not built";
  Command twist({"send", "jetbot_base_controller", "{linear: {x: 0.1}, angular: {z: 0.3}}", "--rate", "20"});
  EXPECT_TRUE(comes_true([] { return state("jetbot/base/position.x") > 0.1; }));
  twist.signal(SIGINT);
  twist.wait();
  ASSERT_TRUE(comes_true([] { return std::abs(state("jetbot/left_wheel_joint/velocity")) < 0.01; }));
  const json at = odometry()["pose"]["pose"]["position"];
  EXPECT_NEAR(at["x"].get<double>(), state("jetbot/base/position.x"), 0.02) << "the wheels do not slip much";
  EXPECT_NEAR(at["y"].get<double>(), state("jetbot/base/position.y"), 0.02);
  EXPECT_GT(state("jetbot/base/position.y"), 0.005) << "to the left";
}

}  // namespace
}  // namespace polyarm
