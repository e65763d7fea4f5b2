/// Driving by keys: the command at a pseudo-terminal, a cell in another process.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <stdlib.h>
#include <termios.h>

#include <cmath>
#include <functional>
#include <memory>

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

const std::string kJetBot = std::string(POLYARM_SOURCE_DIR) + "/examples/jetbot";

/// The JetBot on the mock. Its controller forgives an hour of silence, so that whoever stops it is teleop.
class TeleopTest : public ::testing::Test {
 protected:
  TeleopTest() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_teleop_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
    fs::copy(kJetBot, folder / "jetbot", fs::copy_options::recursive);
    const fs::path yaml = folder / "jetbot/config/jetbot_controllers.yaml";
    std::string text = read_file(yaml);
    const std::string timeout = "cmd_vel_timeout: 0.5";
    text.replace(text.find(timeout), timeout.size(), "cmd_vel_timeout: 3600.0");
    write_file_atomically(yaml, text);
  }
  ~TeleopTest() override {
    cell.reset();
    ::unsetenv("XDG_RUNTIME_DIR");
    fs::remove_all(folder);
  }
  void SetUp() override { start((folder / "jetbot").string()); }
  void start(const std::string& path) {
    cell = std::make_unique<Command>(std::vector<std::string>{"run", path, "--quiet"});
    ASSERT_TRUE(comes_true([] { return run_command({"health"}).exit_code == 0; }));
  }
  static bool comes_true(const std::function<bool()>& claim) {
    for (int tries = 0; tries < 5000; ++tries)
      if (claim()) return true;
    return false;
  }
  /// rad/s, left and right.
  static std::pair<double, double> wheels() {
    const Finished asked = run_command({"interfaces", "--json"});
    const json all = json::parse(asked.output, nullptr, false);
    std::pair<double, double> out{NAN, NAN};
    if (!all.is_object()) return out;
    for (const json& s : all["states"]) {
      if (s["name"] == "jetbot/left_wheel_joint/velocity") out.first = s["value"].get<double>();
      if (s["name"] == "jetbot/right_wheel_joint/velocity") out.second = s["value"].get<double>();
    }
    return out;
  }
  static bool stands() { return wheels() == std::pair<double, double>{0, 0}; }

  fs::path folder;
  std::unique_ptr<Command> cell;
};

TEST_F(TeleopTest, HoldsToDriveAndStopsWhenTheKeyIsLetGo) {
  AtTerminal teleop({"teleop", "--hold", "1", "--first", "2"});
  ASSERT_TRUE(teleop.shows("jetbot_base_controller"));
  ASSERT_TRUE(teleop.shows("speed 0.016 m/s  turn 0.25 rad/s")) << "the controller's limits";
  ASSERT_TRUE(teleop.shows("standing"));
  EXPECT_TRUE(stands());
  // A key that is held, as the terminal gives it: again and teleop.
  EXPECT_TRUE(comes_true([&] {
    teleop.type("i");
    return wheels().first > 0.4 && wheels().second > 0.4;
  }));
  EXPECT_TRUE(teleop.shows("driving +0.016 m/s"));
  EXPECT_TRUE(teleop.shows("standing")) << "no key any more";
  EXPECT_TRUE(comes_true(stands));
  EXPECT_TRUE(comes_true([&] {
    teleop.type("j");
    return wheels().first < -0.2 && wheels().second > 0.2;
  }));
  teleop.type("k");
  EXPECT_TRUE(teleop.shows("standing"));
  EXPECT_TRUE(comes_true(stands));
  teleop.type("\x03");
  EXPECT_EQ(teleop.ends(), 0);
  EXPECT_TRUE(teleop.is_as_it_was());
}

TEST_F(TeleopTest, KeysAreThoseOfTeleopTwistKeyboard) {
  const std::pair<const char*, const char*> keys[] = {
      {"i", "driving +0.5 m/s +0 rad/s"}, {"o", "driving +0.5 m/s -1 rad/s"},
      {"j", "driving +0 m/s +1 rad/s"},   {"l", "driving +0 m/s -1 rad/s"},
      {"u", "driving +0.5 m/s +1 rad/s"}, {",", "driving -0.5 m/s +0 rad/s"},
      {".", "driving -0.5 m/s +1 rad/s"}, {"m", "driving -0.5 m/s -1 rad/s"}};
  AtTerminal teleop({"teleop", "/jetbot_base_controller/cmd_vel", "--speed", "0.5", "--turn", "1"});
  ASSERT_TRUE(teleop.shows("standing"));
  for (const auto& [key, said] : keys) {
    teleop.type(key);
    EXPECT_TRUE(teleop.shows(said)) << key;
    teleop.type(" ");
    EXPECT_TRUE(teleop.shows("standing")) << "any other key stops";
  }
  const std::pair<const char*, const char*> pace[] = {
      {"q", "speed 0.55 m/s  turn 1.1 rad/s"},   {"z", "speed 0.495 m/s  turn 0.99 rad/s"},
      {"w", "speed 0.545 m/s  turn 0.99 rad/s"}, {"x", "speed 0.49 m/s  turn 0.99 rad/s"},
      {"e", "speed 0.49 m/s  turn 1.09 rad/s"},  {"c", "speed 0.49 m/s  turn 0.98 rad/s"}};
  for (const auto& [key, said] : pace) {
    teleop.type(key);
    EXPECT_TRUE(teleop.shows(said)) << key << teleop.seen();
  }
}

TEST_F(TeleopTest, StopsTheBaseAndGivesTheTerminalBackWhateverEndsIt) {
  for (const int number : {SIGTERM, SIGHUP, SIGINT, SIGTSTP}) {
    AtTerminal teleop({"teleop", "--hold", "1", "--first", "2"});
    ASSERT_TRUE(teleop.shows("standing"));
    EXPECT_FALSE(teleop.is_as_it_was()) << "keys come one by one";
    ASSERT_TRUE(comes_true([&] {
      teleop.type("i");
      return wheels().first > 0.4;
    }));
    teleop.type("i");
    teleop.signal(number);
    EXPECT_EQ(teleop.ends(), 0) << number;
    EXPECT_TRUE(teleop.is_as_it_was()) << number;
    EXPECT_TRUE(comes_true(stands)) << number;
  }
  for (const int number : {SIGSEGV, SIGABRT}) {
    AtTerminal teleop({"teleop"});
    ASSERT_TRUE(teleop.shows("standing"));
    teleop.signal(number);
    EXPECT_EQ(teleop.ends(), 128 + number);
    EXPECT_TRUE(teleop.is_as_it_was()) << number;
  }
}

TEST_F(TeleopTest, ACellThatEndsIsASentence) {
  AtTerminal teleop({"teleop"});
  ASSERT_TRUE(teleop.shows("standing"));
  cell->signal(SIGKILL);
  cell->wait();
  teleop.type("i");
  EXPECT_EQ(teleop.ends(), 1);
  EXPECT_NE(teleop.seen().find("the cell has ended"), std::string::npos) << teleop.seen();
  EXPECT_TRUE(teleop.is_as_it_was());
}

TEST_F(TeleopTest, ACellThatStandsStillIsASentence) {
  AtTerminal teleop({"teleop"});
  ASSERT_TRUE(teleop.shows("standing"));
  cell->signal(SIGSTOP);
  teleop.type("i");
  EXPECT_EQ(teleop.ends(), 1);
  EXPECT_NE(teleop.seen().find("has not answered"), std::string::npos) << teleop.seen();
  EXPECT_TRUE(teleop.is_as_it_was());
  cell->signal(SIGCONT);
}

TEST_F(TeleopTest, AnInactiveOrUnknownBaseIsASentence) {
  AtTerminal wrong({"teleop", "jetbot_bas_controller"});
  EXPECT_EQ(wrong.ends(), 1);
  EXPECT_NE(wrong.seen().find("did you mean 'jetbot_base_controller'"), std::string::npos) << wrong.seen();
  ASSERT_EQ(run_command({"control", "state", "jetbot_base_controller", "inactive"}).exit_code, 0);
  AtTerminal teleop({"teleop"});
  EXPECT_EQ(teleop.ends(), 1);
  EXPECT_NE(teleop.seen().find("polyarm control state jetbot_base_controller active"), std::string::npos)
      << teleop.seen();
  EXPECT_TRUE(teleop.is_as_it_was());
}

TEST_F(TeleopTest, WithoutATerminalItSaysSo) {
  const Finished refused = run_command({"teleop"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("reads keys from a terminal"), std::string::npos) << refused.output;
}

class TeleopAtAnArm : public TeleopTest {
 protected:
  void SetUp() override { start(example.path() + "/three_joint.launch"); }
  const test::ExampleCopy example{"three_joint"};
};

TEST_F(TeleopAtAnArm, ACellWithoutABaseIsASentence) {
  AtTerminal teleop({"teleop"});
  EXPECT_EQ(teleop.ends(), 1);
  EXPECT_NE(teleop.seen().find("no controller of this cell takes a twist"), std::string::npos)
      << teleop.seen();
}

TEST(Teleop, WithoutACellItSaysSo) {
  ::setenv("XDG_RUNTIME_DIR", "/nonexistent", 1);
  AtTerminal teleop({"teleop"});
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(teleop.ends(), 1);
  EXPECT_NE(teleop.seen().find("no cell is running"), std::string::npos) << teleop.seen();
}

}  // namespace
}  // namespace polyarm
