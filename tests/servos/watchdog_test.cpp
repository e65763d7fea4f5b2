/// A driver in a process of its own comes to harm; the servos' registers tell what becomes of the joints.
#include "drivers/servo_bus/watchdog.hpp"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <functional>
#include <thread>
#include <tuple>

#include "polyarm/realtime/periodic.hpp"
#include "tests/servos/rig.hpp"
#include "tests/support/driving_process.hpp"

namespace polyarm::test {
namespace {

using servo_bus::Register;
using Frame = std::vector<std::uint8_t>;

/// Two joints on a bus, driven by another process.
class Driven : public ::testing::Test {
 protected:
  void drive(Wire wire, const std::string& command, const std::vector<std::string>& parameters) {
    family = &ServoRig::family_of(wire);
    fake = std::make_unique<FakeBus>(wire, std::vector<int>{1, 2});
    words = {POLYARM_FAKE_PROCESS, wire == Wire::feetech ? "feetech" : "dynamixel", fake->path(), command};
    words.insert(words.end(), parameters.begin(), parameters.end());
    process = std::make_unique<DrivingProcess>(words);
    ASSERT_EQ(process->line(), "driving\n");
  }
  /// Servos of Feetech that turn, and whose watchdog waits for a second.
  void turn() {
    drive(Wire::feetech, "velocity", {"watchdog_ms=1000"});
    ASSERT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
  }
  bool both(const Register& reg, const std::function<bool(std::int32_t)>& is) {
    return fake->wait(1, reg, is) && fake->wait(2, reg, is);
  }
  bool both_at_rest() {
    return both(family->goal_velocity, [](int v) { return v == 0; });
  }
  void kill_it() {
    process->signal(SIGKILL);
    process->wait();
  }
  void TearDown() override {
    process.reset();
    if (fake) fake->close_connection();  // the watchdog ends with the port
  }

  const servo_bus::Family* family = nullptr;
  std::unique_ptr<FakeBus> fake;
  std::vector<std::string> words;
  std::unique_ptr<DrivingProcess> process;
};

struct Death {
  const char* name;
  int signal;        ///< sent to it, or
  const char* word;  ///< told to it
};
class ServoDeaths : public Driven, public ::testing::WithParamInterface<Death> {};

TEST_P(ServoDeaths, StopWhatTurns) {
  turn();
  if (GetParam().word)
    process->tell(GetParam().word);
  else
    process->signal(GetParam().signal);
  EXPECT_TRUE(both_at_rest());
  EXPECT_EQ(fake->get(1, family->torque), 1) << "nothing is let go";
}

INSTANTIATE_TEST_SUITE_P(Table, ServoDeaths,
                         ::testing::Values(Death{"kill", SIGKILL, nullptr}, Death{"term", SIGTERM, nullptr},
                                           Death{"interrupt", SIGINT, nullptr},
                                           Death{"hangup", SIGHUP, nullptr}, Death{"segv", SIGSEGV, nullptr},
                                           Death{"abort", 0, "abort"}, Death{"throw", 0, "throw"},
                                           Death{"exit", 0, "exit"}, Death{"return", 0, "return"}),
                         [](const auto& death) { return std::string(death.param.name); });

using ServoWatchdog = Driven;

TEST_F(ServoWatchdog, SaysNoMoreThanIsNeededByteForByte) {
  turn();
  process->signal(SIGSTOP);
  ASSERT_TRUE(both_at_rest());
  const auto all = fake->heard();
  const Frame stop{0xFF, 0xFF, 0xFE, 0x0A, 0x83, 0x2E, 0x02, 0x01, 0x00, 0x00, 0x02, 0x00, 0x00, 0x41};
  const auto first = std::find(all.begin(), all.end(), stop);
  ASSERT_NE(first, all.end()) << "speed 0 to both joints with one instruction";
  const std::uint64_t before = static_cast<std::uint64_t>(first - all.begin());
  ASSERT_TRUE(fake->wait_for_instructions(before + 3));
  process->signal(SIGKILL);
  process->wait();
  // Speed 0, what their goals are now, how fast they are; and all that once more at the end of the driver.
  const Frame goals{0xFF, 0xFF, 0xFE, 0x06, 0x82, 0x2E, 0x02, 0x01, 0x02, 0x46};
  const Frame speeds{0xFF, 0xFF, 0xFE, 0x06, 0x82, 0x3A, 0x02, 0x01, 0x02, 0x3A};
  ASSERT_TRUE(fake->wait_for_instructions(before + 6));
  const auto now = fake->heard();
  const std::vector<Frame> said(now.begin() + static_cast<std::ptrdiff_t>(before), now.end());
  EXPECT_EQ(said, (std::vector<Frame>{stop, goals, speeds, stop, goals, speeds}));
}

TEST_F(ServoWatchdog, AProcessThatStandsStillIsStoppedAndStaysSo) {
  turn();
  process->signal(SIGSTOP);
  ASSERT_TRUE(both_at_rest());
  process->signal(SIGCONT);
  const std::string said = process->line();
  EXPECT_NE(said.find("error: this process did not run for more than 1000 ms"), std::string::npos) << said;
  EXPECT_NE(said.find("activate it again"), std::string::npos) << said;
  EXPECT_EQ(fake->get(1, family->goal_velocity), 0);
  process->tell("activate");
  ASSERT_EQ(process->line(), "driving\n");
  EXPECT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
}

TEST_F(ServoWatchdog, StoppedRightBehindItsGoalsItTellsAndNothingTurns) {
  turn();
  std::atomic<bool> stopped = false;
  fake->on_instruction([&](std::uint64_t) {  // on the bus's thread, which lets nobody speak meanwhile
    if (!stopped.exchange(true)) process->signal(SIGSTOP);
  });
  ASSERT_TRUE(both_at_rest());
  fake->on_instruction({});
  process->signal(SIGCONT);
  EXPECT_NE(process->line().find("did not run for"), std::string::npos);
  EXPECT_EQ(fake->get(1, family->goal_velocity), 0);
  EXPECT_EQ(fake->get(2, family->goal_velocity), 0);
}

TEST_F(ServoWatchdog, ALoopThatHangsIsStopped) {
  turn();
  process->tell("spin");
  EXPECT_TRUE(both_at_rest());
}

TEST_F(ServoWatchdog, ADeadBusIsTriedUntilItAnswers) {
  turn();
  Mischief dead;
  dead.silent = {1, 2};
  fake->mischief(dead);
  kill_it();
  ASSERT_TRUE(both_at_rest()) << "what they hear they do";
  ASSERT_TRUE(fake->wait_for_instructions(fake->instructions() + 5)) << "but they have not confirmed it";
  const std::string second = DrivingProcess(words).line();
  EXPECT_NE(second.find("in use by component bus"), std::string::npos) << second;
  fake->mischief({});
  // Another master finds the bus free once they have.
  bool driving = false;
  for (int tries = 0; tries < 1000 && !driving; ++tries)
    driving = DrivingProcess(words).line() == "driving\n";
  EXPECT_TRUE(driving);
}

TEST_F(ServoWatchdog, AServoThatHasNotHeardItIsToldAgain) {
  turn();
  static std::atomic<int> deaf;  // the thread of the servos may outlive this function
  deaf = 3;
  fake->on_instruction([&](std::uint64_t) {
    if (deaf > 0 && fake->get(2, family->goal_velocity) == 0) {
      --deaf;
      fake->set(2, family->goal_velocity, 300);
    }
  });
  kill_it();
  ASSERT_TRUE(fake->wait(2, family->present_velocity, [&](int v) { return v == 0 && deaf == 0; }));
  EXPECT_TRUE(both_at_rest());
}

TEST_F(ServoWatchdog, BehindAPulledCableServosTurnOnAndTheDriverSaysThatThePortIsGone) {
  turn();
  process->signal(SIGSTOP);
  fake->close_connection();
  process->signal(SIGCONT);
  EXPECT_NE(process->line().find("is gone"), std::string::npos);
  EXPECT_GT(fake->get(1, family->goal_velocity), 0) << "as documented: nobody can reach them";
}

TEST_F(ServoWatchdog, BehindAPulledCableADynamixelStopsByItself) {
  drive(Wire::dynamixel, "velocity", {"bus_watchdog_ms=500", "answer_timeout_ms=20"});
  ASSERT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
  fake->cut_off();
  EXPECT_NE(process->line().find("no answer in 5 cycles"), std::string::npos);
  EXPECT_TRUE(both(family->watchdog, [](int v) { return v == 0xFF; }));
  EXPECT_EQ(fake->get(1, family->goal_velocity), 0);
}

TEST_F(ServoWatchdog, AStandstillOfJointsInPositionIsNoErrorOfTheirs) {
  for (const Wire wire : {Wire::feetech, Wire::dynamixel}) {
    drive(wire, "position", {});
    ASSERT_TRUE(both(family->goal_position, [](int v) { return v > 2300; }));
    const int goal = fake->get(1, family->goal_position);
    process->signal(SIGSTOP);
    process->signal(SIGCONT);
    ASSERT_TRUE(fake->wait_for_instructions(fake->instructions() + 20))
        << "it goes on; what the cell does is its own";
    EXPECT_EQ(fake->get(1, family->goal_position), goal);
    EXPECT_TRUE(both(family->present_position, [&](int v) { return v == goal; }));
    process.reset();
  }
}

TEST_F(ServoWatchdog, JointsInPositionGoToTheirLastGoalUnlessItIsAskedFor) {
  drive(Wire::feetech, "position", {});
  ASSERT_TRUE(both(family->goal_position, [](int v) { return v > 2300; }));
  fake->set_step(1);
  kill_it();
  const int goal = fake->get(1, family->goal_position);
  EXPECT_GT(goal, 2300);
  // Servos of this bus move with its traffic.
  servo_bus::ServoBus bus(*family, std::make_unique<feetech::Protocol0>());
  serial::PortOptions options;
  options.path = fake->path();
  options.baud = 1'000'000;
  bus.open(options, 1'000'000'000);
  fake->set_step(40);
  for (int k = 0; k < 20; ++k) bus.ping(1);
  EXPECT_EQ(fake->get(1, family->present_position), goal);
}

TEST_F(ServoWatchdog, AskedForItHoldsJointsInPositionWhereTheyAre) {
  drive(Wire::feetech, "position", {"watchdog=on", "watchdog_ms=1000"});
  fake->set_step(1);
  ASSERT_TRUE(both(family->goal_position, [](int v) { return v > 2300; }));
  ASSERT_LT(fake->get(1, family->present_position), 2300);
  kill_it();
  EXPECT_TRUE(both(family->goal_position, [](int v) { return v < 2300; }));
  const int goal = fake->get(1, family->goal_position);
  EXPECT_NEAR(fake->get(1, family->present_position), goal, 20) << "where it was when it was asked";
  EXPECT_EQ(fake->get(1, family->torque), 1);
}

TEST_F(ServoWatchdog, IsForDynamixelOnWhereItIsAskedFor) {
  drive(Wire::dynamixel, "velocity", {"watchdog=on", "watchdog_ms=1000", "bus_watchdog_ms=0"});
  ASSERT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
  kill_it();
  EXPECT_TRUE(both_at_rest());
}

TEST_F(ServoWatchdog, ADynamixelsOwnStopsItAfterAKill) {
  drive(Wire::dynamixel, "velocity", {});
  ASSERT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
  kill_it();
  EXPECT_TRUE(both_at_rest());
  EXPECT_EQ(fake->get(1, family->watchdog), 0xFF) << "by itself";
}

TEST_F(ServoWatchdog, ADynamixelsOwnStopsItInAStandstillAndTheDriverSaysSo) {
  drive(Wire::dynamixel, "velocity", {"bus_watchdog_ms=500"});
  ASSERT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
  process->signal(SIGSTOP);
  ASSERT_TRUE(both(family->watchdog, [](int v) { return v == 0xFF; }));
  process->signal(SIGCONT);
  const std::string said = process->line();
  EXPECT_NE(said.find("was silent for more than 500 ms, since this process stood still"), std::string::npos)
      << said;
  EXPECT_EQ(fake->get(1, family->goal_velocity), 0);
  process->tell("activate");
  ASSERT_EQ(process->line(), "driving\n");
  EXPECT_TRUE(both(family->goal_velocity, [](int v) { return v > 0; }));
}

/// Components in this process.
std::unique_ptr<ServoRig> rig_with(const std::string& command, const std::string& watchdog) {
  auto rig = std::make_unique<ServoRig>(Wire::feetech, command);
  rig->context.parameters["watchdog_ms"] = "5000";
  rig->set("watchdog", watchdog);
  return rig;
}

TEST(ServoWatchdogProgram, RunsOnlyWhereJointsWouldTurnOnOrItIsAskedFor) {
  const std::tuple<const char*, const char*, bool> table[] = {{"velocity", "auto", true},
                                                              {"velocity", "off", false},
                                                              {"velocity", "on", true},
                                                              {"position", "auto", false},
                                                              {"position", "on", true}};
  for (const auto& [command, watchdog, runs] : table) {
    const auto rig = rig_with(command, watchdog);
    ASSERT_TRUE(rig->start());
    EXPECT_EQ(rig->component->watchdog_process() > 0, runs) << command << watchdog;
    rig->component->on_deactivate();
    rig->component->on_cleanup();
    EXPECT_EQ(rig->component->watchdog_process(), 0);
  }
  ServoRig dynamixel(Wire::dynamixel, "velocity");
  ASSERT_TRUE(dynamixel.start());
  EXPECT_EQ(dynamixel.component->watchdog_process(), 0) << "its servos have one of their own";
}

TEST(ServoWatchdogProgram, WithoutItAJointInVelocityIsNotActivated) {
  ServoRig rig(Wire::feetech, "velocity");
  rig.component = std::make_unique<feetech::FeetechComponent>("/nonexistent/watchdog");
  ASSERT_EQ(rig.component->on_init(rig.context), CallbackReturn::success);
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.says("the program polyarm_servo_watchdog cannot be started")) << rig.component->reason();
  EXPECT_TRUE(rig.says("`watchdog: off`")) << rig.component->reason();
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 0);

  ServoRig position(Wire::feetech);
  position.component = std::make_unique<feetech::FeetechComponent>("/nonexistent/watchdog");
  ASSERT_EQ(position.component->on_init(position.context), CallbackReturn::success);
  EXPECT_TRUE(position.start()) << "those in position need none";
}

TEST(ServoWatchdogProgram, WhenItDiesTheDriverStops) {
  const auto rig = rig_with("velocity", "auto");
  ASSERT_TRUE(rig->start());
  rig->commands = {0.5, 0.5, 0.5};
  ASSERT_EQ(rig->step(), ReturnType::ok);
  kill(rig->component->watchdog_process(), SIGKILL);
  while (rig->step() == ReturnType::ok) {  // until the kernel has closed its socket
  }
  EXPECT_TRUE(rig->says("the watchdog of the servos on")) << rig->component->reason();
  EXPECT_TRUE(rig->says("has ended")) << rig->component->reason();
  rig->component->on_error();
  EXPECT_EQ(rig->fake.get(1, rig->family.goal_velocity), 0);
  EXPECT_TRUE(rig->start()) << "with another one";
}

TEST(ServoWatchdogProgram, OneThatIsStoppedTakesNoHeartbeats) {
  const auto rig = rig_with("velocity", "auto");
  ASSERT_TRUE(rig->start());
  const int watchdog = rig->component->watchdog_process();
  kill(watchdog, SIGSTOP);
  int steps = 0;
  while (rig->step() == ReturnType::ok && ++steps < 100'000) {
  }
  EXPECT_TRUE(rig->says("does not run")) << rig->component->reason();
  kill(watchdog, SIGCONT);
}

TEST(ServoWatchdogProgram, WhatTheDriverCannotStopItGoesOnStopping) {
  const auto rig = rig_with("velocity", "auto");
  rig->set("answer_timeout_ms", "5");
  Mischief dead;
  dead.silent = {1, 2, 3};
  ASSERT_TRUE(rig->start());
  rig->commands = {0.5, 0.5, 0.5};
  ASSERT_EQ(rig->step(), ReturnType::ok);
  rig->fake.mischief(dead);
  ASSERT_GT(rig->steps_until_error(), 0);
  rig->component->on_error();
  rig->fake.set(1, rig->family.goal_velocity, 300);  // as if a servo had not heard it
  EXPECT_TRUE(rig->fake.wait(1, rig->family.goal_velocity, [](int v) { return v == 0; }));
  rig->fake.mischief({});
  EXPECT_TRUE(rig->start()) << "which ends when the driver takes over: " << rig->component->reason();
}

/// Of a process that belongs to nobody here.
bool ended(int process) {
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(stat, text);
  return text.empty() || text.find(") Z ") != std::string::npos;
}

TEST(ServoWatchdogProgram, ItEndsWithThePort) {
  const auto rig = rig_with("velocity", "auto");
  ASSERT_TRUE(rig->start());
  const int watchdog = rig->component->watchdog_process();
  ASSERT_FALSE(ended(watchdog));
  rig->fake.close_connection();
  ASSERT_GT(rig->steps_until_error(), 0);
  EXPECT_TRUE(rig->says("is gone"));
  rig->component->on_error();
  const Nanoseconds end = realtime::monotonic_now() + 60'000'000'000;
  while (!ended(watchdog) && realtime::monotonic_now() < end) std::this_thread::yield();
  EXPECT_TRUE(ended(watchdog));
}

TEST(ServoWatchdogProgram, WordsThatAreNoSettingsAreRefused) {
  const auto taken = [](std::vector<std::string> words) {
    words.insert(words.begin(), "watchdog");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    servo_bus::WatchdogSettings settings;
    return servo_bus::settings_from(static_cast<int>(argv.size()), argv.data(), settings);
  };
  const servo_bus::WatchdogSettings settings{
      "feetech", "/dev/a port", 1000000, 10, 250, 60000, {{1, servo_bus::Mode::velocity, 13}, {7}}};
  auto words = words_of(settings);
  EXPECT_TRUE(taken(words));
  EXPECT_EQ(words.back(), "p7:0");
  EXPECT_FALSE(taken({}));
  EXPECT_FALSE(taken({words.begin(), words.begin() + 6})) << "nobody to watch over";
  for (const auto& [at, wrong] : std::vector<std::pair<std::size_t, const char*>>{{2, "0"},
                                                                                  {2, "x"},
                                                                                  {3, "0"},
                                                                                  {4, "-1"},
                                                                                  {5, "5x"},
                                                                                  {6, "x1:0"},
                                                                                  {6, "v300:0"},
                                                                                  {6, "v1"},
                                                                                  {7, ""}}) {
    auto broken = words;
    broken[at] = wrong;
    EXPECT_FALSE(taken(broken)) << at << wrong;
  }
}

}  // namespace
}  // namespace polyarm::test
