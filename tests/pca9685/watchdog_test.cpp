/// A driver in a process of its own comes to harm; the registers tell what becomes of the motors.
#include "drivers/pca9685/watchdog.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include "tests/pca9685/rig.hpp"
#include "tests/support/driving_process.hpp"

namespace polyarm::drivers {
namespace {

using test::DrivingProcess;
using test::FakeBoard;
using test::FakeChip;
using test::Transaction;

bool turning(const FakeChip& c) {
  return c.output(8) == 2048 && c.output(9) == 4096 && c.output(13) == 2048 && c.output(12) == 4096;
}
bool off(const FakeChip& c) {
  return c.all_off();
}

class WatchdogTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(process.line(), "driving\n");
    ASSERT_TRUE(board.wait(turning));
  }
  /// The board stays until the watchdog has had its way, which else tries for a while.
  void TearDown() override {
    board.set_fault(nullptr);
    process.signal(SIGCONT);
    process.signal(SIGKILL);
    process.wait();
    EXPECT_TRUE(board.wait(off));
  }
  FakeBoard board;
  DrivingProcess process{{POLYARM_FAKE_PROCESS, "drive", board.path()}};
};

struct Death {
  const char* name;
  int signal;        ///< sent to it, or
  const char* word;  ///< told to it
};
class Deaths : public WatchdogTest, public ::testing::WithParamInterface<Death> {};

TEST_P(Deaths, TurnMotorsOff) {
  if (GetParam().word)
    process.tell(GetParam().word);
  else
    process.signal(GetParam().signal);
  EXPECT_TRUE(board.wait(off));
}

INSTANTIATE_TEST_SUITE_P(Table, Deaths,
                         ::testing::Values(Death{"kill", SIGKILL, nullptr}, Death{"term", SIGTERM, nullptr},
                                           Death{"interrupt", SIGINT, nullptr},
                                           Death{"hangup", SIGHUP, nullptr}, Death{"segv", SIGSEGV, nullptr},
                                           Death{"abort", 0, "abort"}, Death{"crash", 0, "crash"},
                                           Death{"throw", 0, "throw"}, Death{"exit", 0, "exit"},
                                           Death{"return", 0, "return"}),
                         [](const auto& death) { return std::string(death.param.name); });

TEST_F(WatchdogTest, AProcessThatStandsStillIsStoppedAndStaysSo) {
  process.signal(SIGSTOP);
  ASSERT_TRUE(board.wait([](const FakeChip& c) { return c.all_off() && c.asleep(); }));
  board.forget_log();
  process.signal(SIGCONT);
  const std::string said = process.line();
  EXPECT_NE(said.find("error: this process did not run"), std::string::npos) << said;
  EXPECT_NE(said.find("activate it again"), std::string::npos) << said;
  EXPECT_FALSE(board.was_on()) << "nothing moves by itself";
  process.tell("activate");
  ASSERT_EQ(process.line(), "driving\n");
  EXPECT_TRUE(board.wait(turning));
}

TEST_F(WatchdogTest, ALoopThatHangsIsStopped) {
  process.tell("spin");
  EXPECT_TRUE(board.wait([](const FakeChip& c) { return c.all_off() && c.asleep(); }));
}

TEST_F(WatchdogTest, StoppedAndThenKilledItLeavesMotorsOff) {
  process.signal(SIGSTOP);
  process.signal(SIGKILL);
  EXPECT_TRUE(board.wait(off));
}

TEST_F(WatchdogTest, ADeadBusIsTriedUntilItAnswers) {
  board.set_fault([](const Transaction&) { return EIO; });
  process.signal(SIGKILL);
  process.wait();
  board.forget_log();
  ASSERT_TRUE(board.wait_for_count(5)) << "attempts of the watchdog";
  EXPECT_FALSE(board.look(off));
  board.set_fault(nullptr);
  EXPECT_TRUE(board.wait(off));
}

TEST_F(WatchdogTest, TheNextProcessFindsTheBoardFree) {
  process.signal(SIGKILL);
  process.wait();
  ASSERT_TRUE(board.wait(off));
  DrivingProcess next({POLYARM_FAKE_PROCESS, "drive", board.path()});
  EXPECT_EQ(next.line(), "driving\n");
  EXPECT_TRUE(board.wait(turning));
}

TEST(WatchdogProgram, LiesBesideTheDriverAndSaysWhenItCannotOpenTheBus) {
  using watchdog::Health;
  const std::string program = watchdog::find_program(kPca9685Watchdog);
  ASSERT_NE(program, "");
  watchdog::Link link;
  const auto words = words_of({"/dev/null", 0x60, 250, 656});
  EXPECT_EQ(link.start(program, words), Health::cannot_open);
  EXPECT_EQ(link.start(program, words_of({"/nonexistent", 0x60, 250, 656})), Health::cannot_open);
  EXPECT_EQ(link.start("/bin/false", words), Health::missing);
  EXPECT_EQ(link.start("", words), Health::missing);
}

TEST(WatchdogProgram, WordsThatAreNoSettingsAreRefused) {
  const auto taken = [](std::vector<std::string> words) {
    words.insert(words.begin(), "watchdog");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    WatchdogSettings settings;
    return settings_from(static_cast<int>(argv.size()), argv.data(), settings);
  };
  EXPECT_TRUE(taken({"/dev/i2c-1", "96", "250", "656", "60000"}));
  EXPECT_FALSE(taken({}));
  EXPECT_FALSE(taken({"/dev/i2c-1", "96", "250", "656"}));
  EXPECT_FALSE(taken({"/dev/i2c-1", "300", "250", "656", "60000"}));
  EXPECT_FALSE(taken({"/dev/i2c-1", "96", "0", "656", "60000"}));
  EXPECT_FALSE(taken({"/dev/i2c-1", "96", "2x", "656", "60000"}));
}

}  // namespace
}  // namespace polyarm::drivers
