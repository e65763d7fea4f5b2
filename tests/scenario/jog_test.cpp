/// Motion by hand from other processes: keys at a pseudo-terminal, and commands of scripts.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/file.hpp"
#include "tests/support/at_terminal.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using nlohmann::json;
using test::AtTerminal;
using test::Command;
using test::Finished;
using test::run_command;
namespace fs = std::filesystem;

/// The arm of examples/r6bot on the mock, without a program.
class JogCommandTest : public ::testing::Test {
 protected:
  JogCommandTest() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_jog_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
    fs::create_directory(folder / "bench");
    write_file_atomically(folder / "bench/cell.yaml",
                          "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
                          "/examples/r6bot/r6bot.urdf, hardware: mock}\n");
    cell = std::make_unique<Command>(std::vector<std::string>{"run", (folder / "bench").string(), "--quiet"});
  }
  ~JogCommandTest() override {
    cell.reset();
    ::unsetenv("XDG_RUNTIME_DIR");
    fs::remove_all(folder);
  }
  void SetUp() override {
    ASSERT_TRUE(comes_true([] { return run_command({"health"}).exit_code == 0; }));
  }
  static bool comes_true(const std::function<bool()>& claim) {
    for (int tries = 0; tries < 5000; ++tries)
      if (claim()) return true;
    return false;
  }
  static double joint(const std::string& name) {
    const json all = json::parse(run_command({"interfaces", "--json"}).output, nullptr, false);
    if (all.is_object())
      for (const json& s : all["states"])
        if (s["name"] == "arm/" + name + "/position") return s["value"].get<double>();
    return NAN;
  }

  fs::path folder;
  std::unique_ptr<Command> cell;
};

TEST_F(JogCommandTest, ScriptsMoveJointsAndTheTcpBySoMuch) {
  Finished done = run_command({"jog", "--joint", "joint_2", "--by", "20deg"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NEAR(joint("joint_2"), 20 * M_PI / 180, 1e-6);
  EXPECT_EQ(run_command({"jog", "--joint", "joint_3", "--by", "0.8"}).exit_code, 0);
  EXPECT_EQ(run_command({"jog", "--joint", "joint_5", "--by", "45deg", "--speed", "50%"}).exit_code, 0);
  done = run_command({"jog", "--tcp", "z", "--by", "-10mm", "--frame", "tool", "--json"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  const json state = json::parse(done.output, nullptr, false);
  ASSERT_TRUE(state.is_object()) << done.output;
  EXPECT_TRUE(state["done"].get<bool>());
  const double before = joint("joint_1");
  EXPECT_EQ(run_command({"jog", "--joint", "joint_1", "--speed", "10deg/s", "--for", "0.3s"}).exit_code, 0);
  EXPECT_GT(joint("joint_1"), before + 0.01);
}

TEST_F(JogCommandTest, MistakesAreToldWithWhatIsMeant) {
  const Finished wrong = run_command({"jog", "--joint", "joint2", "--by", "5deg"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.output.find("did you mean 'joint_2'"), std::string::npos) << wrong.output;
  EXPECT_EQ(run_command({"jog", "--joint", "joint_2"}).exit_code, 2);
  EXPECT_EQ(run_command({"jog", "--by", "5deg"}).exit_code, 2);
  EXPECT_NE(
      run_command({"jog", "--tcp", "z", "--by", "5mm", "--frame", "tol"}).output.find("did you mean 'tool'"),
      std::string::npos);
  const Finished far = run_command({"jog", "--joint", "joint_2", "--by", "400deg"});
  EXPECT_EQ(far.exit_code, 1);
  EXPECT_NE(far.output.find("joint limit joint_2"), std::string::npos) << far.output;
  EXPECT_NE(run_command({"jog"}).output.find("from a terminal"), std::string::npos);
}

TEST_F(JogCommandTest, AKeyMovesAsLongAsItIsHeld) {
  AtTerminal keys({"jog", "--first", "0.2"});
  ASSERT_TRUE(keys.shows("joint_1"));
  keys.type("q");
  ASSERT_TRUE(comes_true([] { return joint("joint_1") > 0.005; }));
  double last = -1;
  ASSERT_TRUE(comes_true([&] { return std::exchange(last, joint("joint_1")) == last; })) << "it stops";
  keys.type("a");
  const double top = last;
  ASSERT_TRUE(comes_true([&] { return joint("joint_1") < top; }));
  keys.type("p+w");  // by steps, longer ones; joint 2
  ASSERT_TRUE(keys.shows("by step"));
  ASSERT_TRUE(comes_true([] { return std::abs(joint("joint_2") - 0.01) < 1e-6; }));
  keys.type("m");
  ASSERT_TRUE(keys.shows("TCP along tool"));
  keys.type("\x03");
  EXPECT_EQ(keys.ends(), 0);
  EXPECT_TRUE(keys.is_as_it_was());
}

TEST_F(JogCommandTest, KillingWhoJogsStopsTheRobot) {
  auto keys = std::make_unique<AtTerminal>(std::vector<std::string>{"jog", "--first", "2"});
  ASSERT_TRUE(keys->shows("joint_1"));
  keys->type("q");
  ASSERT_TRUE(comes_true([] { return joint("joint_1") > 0.005; }));
  keys->signal(SIGKILL);
  double last = -1;
  EXPECT_TRUE(comes_true([&] { return std::exchange(last, joint("joint_1")) == last; }));
  EXPECT_LT(last, 1.0);
}

}  // namespace
}  // namespace polyarm
