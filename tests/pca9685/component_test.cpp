#include "drivers/pca9685/component.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <random>

#include "tests/pca9685/rig.hpp"
#include "tests/support/waiting_component.hpp"

namespace polyarm::drivers {
namespace {

using hardware::CallbackReturn;
using hardware::Cycle;
using hardware::ReturnType;
using test::FakeBoard;
using test::FakeChip;
using test::jetbot;
using test::Transaction;
using test::wheels_on;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Cycle kCycle{0, 20'000'000, 0};

class ComponentTest : public ::testing::Test {
 protected:
  ComponentTest() : parameters(jetbot(board.path())) {
    parameters["watchdog_ms"] = "5000";  // however slow the machine is, these tests are not late
  }

  void begin() {
    component.on_init(wheels_on(parameters));
    ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
    ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  }
  ReturnType write(double left, double right) {
    const double commands[] = {left, right};
    return component.write(kCycle, commands);
  }
  ReturnType read() { return component.read(kCycle, states); }
  /// Ticks of the left motor, signed; the right one's.
  int left() {
    return board.look([](const FakeChip& c) { return speed(c, 8, 9, 10); });
  }
  int right() {
    return board.look([](const FakeChip& c) { return speed(c, 13, 12, 11); });
  }
  static int speed(const FakeChip& c, int enable, int positive, int negative) {
    const int sign = (c.output(positive) != 0 ? 1 : 0) - (c.output(negative) != 0 ? 1 : 0);
    return sign * c.output(enable);
  }
  bool all_off() {
    return board.look([](const FakeChip& c) { return c.all_off(); });
  }

  FakeBoard board;
  std::map<std::string, std::string> parameters;
  double states[4] = {kNone, kNone, kNone, kNone};
  Pca9685Component component{test::fake_environment()};
};

TEST_F(ComponentTest, IsRealAndWaitsForItsBus) {
  EXPECT_TRUE(component.real());
  EXPECT_TRUE(component.blocks());
}

TEST_F(ComponentTest, ConfiguringAndActivatingMovesNothing) {
  begin();
  EXPECT_TRUE(all_off());
  EXPECT_FALSE(board.was_on());
  EXPECT_EQ(board.look([](const FakeChip& c) { return c.at(0xFE); }), 3) << "1600 Hz";
  EXPECT_EQ(board.look([](const FakeChip& c) { return c.at(0x00); }), 0x20);
}

TEST_F(ComponentTest, MotorsThatAnotherLeftRunningAreOffAfterConfigure) {
  BusFailure failure;
  const auto other = test::open_fake_bus(board.path(), FakeBoard::kAddress, failure);
  Pca9685 chip(*other);
  ASSERT_FALSE(chip.start(30));
  ASSERT_FALSE(chip.set(8, 4096));
  ASSERT_FALSE(chip.set(9, 4096));
  ASSERT_FALSE(all_off());
  component.on_init(wheels_on(parameters));
  ASSERT_EQ(component.on_configure(), CallbackReturn::success);
  EXPECT_TRUE(all_off());
}

TEST_F(ComponentTest, DrivesEachWheelAtItsSpeed) {
  begin();
  EXPECT_EQ(write(0.25, -0.5), ReturnType::ok);
  EXPECT_EQ(left(), 1024);
  EXPECT_EQ(right(), -2048);
  EXPECT_EQ(write(3, 0), ReturnType::ok);
  EXPECT_EQ(left(), 4096) << "clamped";
  EXPECT_EQ(right(), 0);
}

TEST_F(ComponentTest, StatesAreWhatIsCommanded) {
  parameters["max_duty"] = "0.5";
  begin();
  write(0.4, -2);
  read();
  EXPECT_DOUBLE_EQ(states[1], 0.4);
  EXPECT_DOUBLE_EQ(states[3], -0.5) << "after the clamp";
  for (int k = 1; k < 50; ++k) read();
  EXPECT_NEAR(states[0], 0.4, 1e-9) << "one second";
  EXPECT_NEAR(states[2], -0.5, 1e-9);
}

TEST_F(ComponentTest, ADirectionChangesWhileTheMotorIsOff) {
  begin();
  write(0.5, 0);
  board.forget_log();
  write(-0.5, 0);
  const std::vector<Transaction> log = board.log();
  ASSERT_EQ(log.size(), 4u);
  EXPECT_EQ(log[0].bytes[0], 0x06 + 4 * 8) << "enable off first";
  EXPECT_EQ(log[0].bytes[4], 0x10);
  EXPECT_EQ(log[3].bytes[0], 0x06 + 4 * 8) << "and on last";
  EXPECT_EQ(left(), -2048);
}

TEST_F(ComponentTest, WhatDoesNotChangeIsNotSent) {
  begin();
  write(0.5, 0.5);
  board.forget_log();
  for (int k = 0; k < 3; ++k) write(0.5, 0.5);
  EXPECT_TRUE(board.log().empty());
}

TEST_F(ComponentTest, AWheelWithoutACommandIsOff) {
  parameters["stop"] = "brake";
  begin();
  write(0.5, 0.5);
  EXPECT_EQ(write(kNone, 0), ReturnType::ok);
  EXPECT_EQ(board.look([](const FakeChip& c) { return c.output(8) + c.output(9) + c.output(10); }), 0);
  EXPECT_EQ(board.look([](const FakeChip& c) { return c.output(11) + c.output(12) + c.output(13); }),
            3 * 4096)
      << "a brake";
}

TEST_F(ComponentTest, AnInfiniteCommandStopsAndNamesTheJoint) {
  begin();
  write(0.5, 0.5);
  EXPECT_EQ(write(0.5, INFINITY), ReturnType::error);
  EXPECT_TRUE(all_off());
  EXPECT_NE(component.reason().find("right_wheel_joint"), std::string::npos) << component.reason();
}

TEST_F(ComponentTest, DeactivatedItIsOffAndTakesNoCommands) {
  begin();
  write(0.5, 0.5);
  EXPECT_EQ(component.on_deactivate(), CallbackReturn::success);
  EXPECT_TRUE(all_off());
  board.forget_log();
  EXPECT_EQ(write(0.5, 0.5), ReturnType::ok);
  EXPECT_FALSE(board.was_on());
  EXPECT_EQ(read(), ReturnType::ok);
  EXPECT_EQ(states[1], 0);
  EXPECT_EQ(component.on_activate(), CallbackReturn::success);
  EXPECT_TRUE(all_off());
  write(0.5, 0.5);
  EXPECT_EQ(left(), 2048);
}

TEST_F(ComponentTest, EveryWayOutTurnsMotorsOff) {
  for (const auto way : {&hardware::Component::on_deactivate, &hardware::Component::on_cleanup,
                         &hardware::Component::on_shutdown, &hardware::Component::on_error}) {
    begin();
    write(0.5, 0.5);
    ASSERT_FALSE(all_off());
    EXPECT_EQ((component.*way)(), CallbackReturn::success);
    EXPECT_TRUE(all_off());
    component.on_cleanup();
  }
  {
    Pca9685Component other(test::fake_environment());
    other.on_init(wheels_on(parameters));
    ASSERT_EQ(other.on_configure(), CallbackReturn::success);
    ASSERT_EQ(other.on_activate(), CallbackReturn::success);
    const double commands[] = {1, 1};
    other.write(kCycle, commands);
    ASSERT_FALSE(all_off());
  }
  EXPECT_TRUE(all_off()) << "destroyed";
}

TEST_F(ComponentTest, ABoardHasOneMaster) {
  begin();
  Pca9685Component second(test::fake_environment());
  second.on_init(wheels_on(parameters));
  EXPECT_EQ(second.on_configure(), CallbackReturn::failure);
  EXPECT_NE(second.reason().find("component JetBot"), std::string::npos) << second.reason();
}

TEST_F(ComponentTest, ABusThatDoesNotOpenIsASentence) {
  const std::string missing = "/nonexistent/" + std::to_string(getpid());
  parameters["bus"] = missing;
  component.on_init(wheels_on(parameters));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_NE(component.reason().find(missing + " cannot be opened"), std::string::npos) << component.reason();
}

TEST_F(ComponentTest, NobodyAtTheAddressIsASentence) {
  parameters["address"] = "0x41";
  component.on_init(wheels_on(parameters));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_NE(component.reason().find("0x41 did not answer"), std::string::npos) << component.reason();
}

TEST_F(ComponentTest, WithoutItsWatchdogItDoesNotStart) {
  Pca9685Component alone({test::open_fake_bus, "/nonexistent/watchdog"});
  alone.on_init(wheels_on(parameters));
  EXPECT_EQ(alone.on_configure(), CallbackReturn::failure);
  EXPECT_NE(alone.reason().find("polyarm_pca9685_watchdog"), std::string::npos) << alone.reason();
  EXPECT_FALSE(board.was_on());
}

/// Fails transaction `at` of this process, and `count` - 1 after it.
auto failing(int at, int count) {
  return [at, count, n = 0](const Transaction& t) mutable {
    if (t.from != getpid()) return 0;
    const int k = n++;
    return k >= at && k < at + count ? EREMOTEIO : 0;
  };
}

TEST_F(ComponentTest, AnErrorAtAnyTransactionIsToldAndNothingKeepsTurning) {
  component.on_init(wheels_on(parameters));
  int sent = 0, survived = 0;
  board.set_fault([&sent](const Transaction& t) {
    sent += t.from == getpid();
    return 0;
  });
  const auto use = [&] {
    bool fine = component.on_configure() == CallbackReturn::success &&
                component.on_activate() == CallbackReturn::success && write(0.5, -0.5) == ReturnType::ok;
    for (int k = 0; k < 10 && fine; ++k) fine = read() == ReturnType::ok;
    fine = fine && write(-0.5, 0.5) == ReturnType::ok && component.on_deactivate() == CallbackReturn::success;
    return fine;
  };
  ASSERT_TRUE(use()) << component.reason();
  component.on_cleanup();
  const int all = sent;
  ASSERT_GT(all, 20);
  for (int n = 0; n < all; ++n) {
    board.set_fault(failing(n, 1));
    const bool fine = use();
    survived += fine;
    if (!fine) {
      EXPECT_NE(component.reason().find("0x60"), std::string::npos) << n << component.reason();
    }
    EXPECT_TRUE(all_off()) << "transaction " << n;
    board.set_fault(nullptr);
    component.on_error();
    EXPECT_TRUE(use()) << "usable again after transaction " << n << ": " << component.reason();
    component.on_cleanup();
  }
  EXPECT_LE(survived, 5) << "only orders to stop are repeated";
}

TEST_F(ComponentTest, WhateverABadBusDoesMotorsAreOffInTheEnd) {
  component.on_init(wheels_on(parameters));
  std::mt19937 random(0x60);
  const auto chance = [&random](int percent) { return static_cast<int>(random() % 100) < percent; };
  for (int round = 0; round < 60; ++round) {
    board.set_fault([noise = std::mt19937(static_cast<unsigned>(round))](const Transaction&) mutable {
      constexpr int kErrors[] = {EREMOTEIO, EIO, ETIMEDOUT, EAGAIN};
      return noise() % 100 < 8 ? kErrors[noise() % 4] : 0;
    });
    component.on_configure();
    component.on_activate();
    for (int k = 0; k < 20; ++k) {
      write(std::uniform_real_distribution<double>(-2, 2)(random), chance(10) ? kNone : 0.3);
      read();
      if (chance(5)) component.on_deactivate();
      if (chance(5)) component.on_activate();
    }
    component.on_error();
    board.set_fault(nullptr);
    EXPECT_TRUE(board.wait([](const FakeChip& c) { return c.all_off(); })) << "round " << round;
    EXPECT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
    EXPECT_TRUE(all_off());
  }
}

TEST_F(ComponentTest, ABusThatDiesWhileDrivingEndsInAnErrorAndTheWatchdogGoesOnTrying) {
  begin();
  write(0.5, 0.5);
  board.forget_log();
  board.set_fault([](const Transaction&) { return EREMOTEIO; });
  EXPECT_EQ(write(0.6, 0.6), ReturnType::error);
  const std::string reason = component.reason();
  EXPECT_NE(reason.find("left_wheel_joint"), std::string::npos) << reason;
  EXPECT_NE(reason.find("0x60"), std::string::npos) << reason;
  EXPECT_EQ(write(0.6, 0.6), ReturnType::error) << "and so it stays";
  EXPECT_EQ(read(), ReturnType::error);
  EXPECT_FALSE(all_off()) << "nobody can reach the chip";
  ASSERT_TRUE(board.wait_for_count(board.log().size() + 3)) << "the watchdog tries";
  board.set_fault(nullptr);
  EXPECT_TRUE(board.wait([](const FakeChip& c) { return c.all_off(); }));
  EXPECT_EQ(component.on_error(), CallbackReturn::success);
  EXPECT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  EXPECT_EQ(component.on_activate(), CallbackReturn::success);
  EXPECT_EQ(write(0.5, 0.5), ReturnType::ok);
  EXPECT_EQ(left(), 2048);
}

TEST_F(ComponentTest, ABoardThatLosesItsPowerIsFoundOutWithoutACommand) {
  begin();
  write(0.5, 0.5);
  BusFailure failure;
  const auto other = test::open_fake_bus(board.path(), FakeBoard::kAddress, failure);
  const std::uint8_t asleep[] = {0x00, 0x11};
  ASSERT_EQ(other->write(asleep), 0);
  ReturnType last = ReturnType::ok;
  for (int k = 0; k < 10 && last == ReturnType::ok; ++k) last = read();
  EXPECT_EQ(last, ReturnType::error);
  EXPECT_NE(component.reason().find("lost its settings"), std::string::npos) << component.reason();
}

TEST_F(ComponentTest, WithoutItsWatchdogItDrivesNoFurther) {
  begin();
  write(0.5, 0.5);
  const int watchdog = component.watchdog_process();
  ASSERT_GT(watchdog, 1);
  kill(watchdog, SIGKILL);
  ReturnType last = ReturnType::ok;
  while (last == ReturnType::ok) last = read();  // until the kernel has closed its socket
  EXPECT_NE(component.reason().find("has ended"), std::string::npos) << component.reason();
  EXPECT_TRUE(all_off());
}

TEST_F(ComponentTest, ReadAndWriteNeitherAllocateNorThrow) {
  begin();
  for (const double speed : {0.5, -0.5, kNone}) {
    const double commands[] = {speed, -speed};
    EXPECT_TRUE(test::neither_allocates_nor_throws(component, 100, states, commands)) << speed;
    ASSERT_EQ(write(speed, -speed), ReturnType::ok) << component.reason();
  }
  board.set_fault([](const Transaction& t) { return t.from == getpid() ? EREMOTEIO : 0; });
  const double commands[] = {0.5, 0.5};
  EXPECT_TRUE(test::neither_allocates_nor_throws(component, 10, states, commands)) << "nor on a dead bus";
  EXPECT_EQ(read(), ReturnType::error);
}

TEST_F(ComponentTest, AWatchdogThatIsStoppedTakesNoHeartbeats) {
  begin();
  const int watchdog = component.watchdog_process();
  ASSERT_GT(watchdog, 1);
  kill(watchdog, SIGSTOP);
  int writes = 0;
  while (write(0.5, 0.5) == ReturnType::ok && ++writes < 100'000) {
  }
  EXPECT_NE(component.reason().find("does not run"), std::string::npos) << component.reason();
  EXPECT_TRUE(all_off());
  kill(watchdog, SIGCONT);
}

}  // namespace
}  // namespace polyarm::drivers
