/// A component whose device has a clock of its own paces the control loop.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>

#include "polyarm/cell/run.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

/// A mock with a clock: its next cycle begins as soon as it is asked.
class Clocked : public drivers::MockComponent {
 public:
  static inline std::atomic<int> asked{0}, comes{0};
  static inline std::atomic<Nanoseconds> patience{0};
  bool paces() const noexcept override { return true; }
  bool await_cycle(Nanoseconds timeout) noexcept override {
    patience = timeout;
    return ++asked <= comes;
  }
};

cell::CellFile cell_of(const test::Folder& folder, const std::string& robots) {
  hardware::register_driver("clocked", [] { return std::unique_ptr<hardware::Component>(new Clocked); });
  return cell::read_cell_file(folder.write("cell.yaml", "polyarm: cell/1\nrate: 1\nrobots:\n" + robots));
}
const std::string kModel = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf, hardware: clocked";

TEST(Pacing, TheLoopFollowsTheDevicesClockAndGoesOnWithoutIt) {
  const test::Folder folder;
  Clocked::asked = 0;
  Clocked::comes = 40;
  cell::Observer nobody;
  test::OpenCell cell(cell_of(folder, "  arm: {model: " + kModel + "}\n"), description::Catalogue({}), {},
                      nobody);
  cell::RunOptions options;
  options.socket = options.console = false;
  options.seconds = 60;  // of the device's time; at 1 Hz of the loop's own it would be a minute
  const cell::RunResult result = cell::run(cell, options, nobody);
  EXPECT_GE(result.health.cycles, 60u) << "a device that fell silent does not stop the loop";
  EXPECT_GE(Clocked::asked, 60);
  EXPECT_EQ(Clocked::patience, 2'000'000'000) << "and is waited for no longer than two periods";
}

TEST(Pacing, ALoopHasOneClock) {
  const test::Folder folder;
  cell::Observer nobody;
  try {
    test::OpenCell cell(
        cell_of(folder, "  a: {model: " + kModel + ", rate: 1}\n  b: {model: " + kModel + ", rate: 0.5}\n"),
        description::Catalogue({}), {}, nobody);
    FAIL() << "two clocks were taken";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "two-clocks") << e.what();
  }
}

/// Rings in the tick itself, so that its request is there before the next one.
struct Ringing : cell::Door {
  int rings = 5;
  std::string seen;
  std::shared_ptr<realtime::Bell> bell;
  void serve() override {
    seen += 's';
    if (bell && rings-- > 0) bell->ring();
  }
  void take() override { seen += 't'; }
  void set_wakeup(const std::shared_ptr<realtime::Bell>& given) override { bell = given; }
  std::string address() const override { return "nowhere"; }
};

TEST(Pacing, WhatRingsIsTakenBeforeTheNextTick) {
  const test::Folder folder;
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  cell::Observer nobody;
  test::OpenCell cell(
      cell::read_cell_file(folder.write(
          "cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + std::string(POLYARM_SOURCE_DIR) +
                           "/examples/r6bot/r6bot.urdf, hardware: mock}\n")),
      description::Catalogue({}), {}, nobody);
  Ringing door;
  cell::RunOptions options;
  options.socket = options.console = false;
  options.seconds = 0.1;
  options.doors = {&door};
  cell::run(cell, options, nobody);
  EXPECT_EQ(door.bell, nullptr) << "it is taken down at the end";
  std::size_t at = 0;
  for (int i = 0; i < 5; ++i) {
    at = door.seen.find('s', at);
    ASSERT_LT(at + 1, door.seen.size()) << door.seen;
    EXPECT_EQ(door.seen[++at], 't') << "ring " << i << " of " << door.seen;
  }
}

}  // namespace
}  // namespace polyarm
