/// Who asks a running cell how it is doing, however often, has nothing that the control loop waits for.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "tests/support/lock_step_cell.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm {
namespace {

const std::string kPolledControllers = R"(
controller_manager:
  ros__parameters:
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    beside: {type: joint_state_broadcaster/JointStateBroadcaster, is_async: true}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
follow: {ros__parameters: {joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]}}
)";

TEST(Polling, NeitherLocksNorAllocatesNorWaitsInTheControlThread) {
  constexpr int kCycles = 100'000;
  test::LockStepCell cell(kPolledControllers, true);
  cell.tick();
  control::ControlLoop& loop = cell.cell().loop();
  const std::uint64_t before = loop.health().cycles;
  std::atomic<bool> done{false};
  std::string violations;
  std::thread control([&] {
    const test::RealtimeGuard guard;
    for (int k = 0; k < kCycles; ++k) {
      loop.woke(0, 0);
      loop.step_next();
    }
    violations = guard.violations();
    done = true;
  });
  int answered = 0;
  const auto count = [&answered](const std::string& line) {
    answered += line.find("\"ok\":true") != std::string::npos ? 1 : 0;
    return true;
  };
  while (!done || answered < 100) {
    for (const char* request : {"health", "interfaces", "control.list", "hardware.list", "limits"})
      cell.cell().requests().handle(std::string("{\"request\": \"") + request + "\"}", count);
    cell.cell().tick(cell.cell().snapshot().cycle.time);
  }
  control.join();
  if (test::RealtimeGuard::watches()) {
    EXPECT_EQ(violations, "");
  }
  EXPECT_EQ(std::uint64_t{loop.health().cycles} - before, static_cast<std::uint64_t>(kCycles));
  EXPECT_GE(answered, 100);
}

}  // namespace
}  // namespace polyarm
