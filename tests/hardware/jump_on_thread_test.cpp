/// A component on a thread of its own whose measured position cannot be true: judged by the time that may lie
/// between two of its exchanges, not by the loop's.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <semaphore>
#include <span>
#include <string>
#include <vector>

#include "polyarm/realtime/periodic.hpp"
#include "tests/hardware/exchange_rig.hpp"

namespace polyarm::hardware {
namespace {

/// Stands where the test says; each read waits at a gate where there is one.
class Placed : public Component {
 public:
  CallbackReturn on_init(const ComponentContext&) override { return CallbackReturn::success; }
  std::vector<InterfaceDescription> state_interfaces() const override { return {{"a/j/position", 0.0}}; }
  std::vector<InterfaceDescription> command_interfaces() const override { return {{"a/j/position"}}; }
  ReturnType read(const Cycle&, std::span<double> states) noexcept override {
    if (gate) gate->acquire();
    states[0] = at;
    ++reads;
    reads.notify_all();
    return ReturnType::ok;
  }
  ReturnType write(const Cycle&, std::span<const double>) noexcept override { return ReturnType::ok; }
  std::atomic<double> at{0};
  std::atomic<int> reads{0};
  std::counting_semaphore<1'000'000>* gate = nullptr;
};

constexpr Nanoseconds kPeriod = 10'000'000;  // of the component; the loop's is 1 ms

struct Rig {
  std::counting_semaphore<1'000'000> gate{0};
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware{table, jobs};
  Placed* placed;
  Cycle cycle{0, 1'000'000, 0};

  Rig(Nanoseconds period, bool lock_step, double velocity) {
    auto made = std::make_unique<Placed>();
    placed = made.get();
    if (!lock_step) placed->gate = &gate;
    ComponentContext context;
    context.name = "a";
    context.period = cycle.period;
    HostOptions options;
    options.async = true;
    options.period = period;
    options.divisor = 10;
    options.lock_step = lock_step;
    hardware.add(std::move(made), context, options);
    hardware.configure_and_activate();
    table.seal();
    hardware.exchange().watch({{0, 0, velocity}}, cycle.period);
  }
  ~Rig() { gate.release(100'000); }
  FaultEvent step() {
    const FaultEvent first = read(hardware, cycle), second = write(hardware, cycle);
    cycle.time += cycle.period;
    ++cycle.index;
    return first ? first : second;
  }
  FaultEvent run(int cycles) {
    for (int k = 0; k < cycles; ++k)
      if (const FaultEvent fault = step()) return fault;
    return {};
  }
  /// Lets the component's thread read once, and the loop take it.
  FaultEvent exchange() {
    const int before = placed->reads;
    step();
    gate.release();
    while (placed->reads == before) {
      if (const FaultEvent fault = step()) return fault;
    }
    return run(100);
  }
};

class JumpOnAThread : public testing::TestWithParam<Nanoseconds> {};

TEST_P(JumpOnAThread, IsAFaultInLockStep) {
  Rig rig(GetParam(), true, 2);
  EXPECT_FALSE(rig.run(100));
  rig.placed->at = 0.9;
  const FaultEvent fault = rig.run(100);
  EXPECT_EQ(fault.cause, StopCause::jump);
  EXPECT_NE(rig.hardware.diagnostics().reason(0).find("a/j/position changed by more"), std::string::npos)
      << rig.hardware.diagnostics().reason(0);
  EXPECT_EQ(rig.hardware.diagnostics().blamed_interface(0), "a/j/position");
}

TEST_P(JumpOnAThread, MotionAtFullSpeedIsNone) {
  Rig rig(GetParam(), true, 2);
  for (int k = 0; k < 1000; ++k) {
    rig.placed->at = rig.placed->at + 2e-3;
    ASSERT_FALSE(rig.step()) << k;
  }
}

TEST_P(JumpOnAThread, IsAFaultOfARealThread) {
  Rig rig(GetParam(), false, 1e-3);  // so slow that no machine is late enough to permit it
  for (int k = 0; k < 5; ++k) ASSERT_FALSE(rig.exchange()) << k;
  rig.placed->at = 0.9;
  StopCause seen = StopCause::none;  // an exchange that was under way may still have the place before
  for (int k = 0; k < 3 && seen == StopCause::none; ++k) seen = rig.exchange().cause;
  EXPECT_EQ(seen, StopCause::jump);
}

TEST_P(JumpOnAThread, WhatAJointMovedDuringALongExchangeIsNone) {
  Rig rig(GetParam(), false, 2);
  for (int k = 0; k < 5; ++k) ASSERT_FALSE(rig.exchange()) << k;
  for (const Nanoseconds from = realtime::monotonic_now(); realtime::monotonic_now() < from + 15 * kPeriod;)
    rig.step();
  rig.placed->at = 0.25;  // 0.15 s at 2 rad/s; of two reads one after the other it would be a jump
  EXPECT_FALSE(rig.exchange());
}

INSTANTIATE_TEST_SUITE_P(OfItsOwnPeriodAndTriggered, JumpOnAThread, testing::Values(kPeriod, Nanoseconds{0}));

TEST(JumpInTheLoop, WhatAJointMovedWhileCyclesWereSkippedIsNone) {
  for (const bool skipped : {true, false}) {
    InterfaceTable table;
    realtime::Jobs jobs;
    Hardware hardware(table, jobs);
    auto made = std::make_unique<Placed>();
    Placed* placed = made.get();
    ComponentContext context;
    context.name = "a";
    hardware.add(std::move(made), context);
    hardware.configure_and_activate();
    table.seal();
    const Cycle cycle{0, 1'000'000, 0};
    hardware.exchange().watch({{0, 0, 2}}, cycle.period);
    ASSERT_FALSE(read(hardware, cycle));
    placed->at = 0.1;
    if (skipped) hardware.exchange().skipped(50'000'000);
    EXPECT_EQ(read(hardware, cycle).cause, skipped ? StopCause::none : StopCause::jump);
    placed->at = 0.2;
    EXPECT_EQ(read(hardware, cycle).cause, skipped ? StopCause::jump : StopCause::none) << "counted once";
  }
}

}  // namespace
}  // namespace polyarm::hardware
