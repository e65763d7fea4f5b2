/// A component with a rate and a thread of its own beside the loop.
#include "polyarm/hardware/own_clock.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <semaphore>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm/realtime/periodic.hpp"
#include "tests/hardware/exchange_rig.hpp"

namespace polyarm::hardware {
namespace {

/// Echoes its one command, counts its exchanges, waits at a gate where there is one.
class Slow : public Component {
 public:
  CallbackReturn on_init(const ComponentContext&) override { return CallbackReturn::success; }
  std::vector<InterfaceDescription> state_interfaces() const override { return {{"a/j/position", 0.25}}; }
  std::vector<InterfaceDescription> command_interfaces() const override { return {{"a/j/position"}}; }
  CallbackReturn on_cleanup() override {
    in_call_at_cleanup = in_call.load();
    return CallbackReturn::success;
  }
  ReturnType read(const Cycle& cycle, std::span<double> states) noexcept override {
    in_call = true;
    if (gate) gate->acquire();
    times.push_back(cycle.time);
    period = cycle.period;
    if (std::isfinite(last_)) states[0] = last_;
    ++reads;
    in_call = false;
    return fails ? ReturnType::error : ReturnType::ok;
  }
  ReturnType write(const Cycle&, std::span<const double> commands) noexcept override {
    last_ = commands[0];
    ++writes;
    return ReturnType::ok;
  }
  std::atomic<int> reads{0}, writes{0};
  std::atomic<bool> fails{false}, in_call{false};
  bool in_call_at_cleanup = false;
  std::counting_semaphore<1000000>* gate = nullptr;
  std::vector<Nanoseconds> times;  // of lock-step tests
  Nanoseconds period = 0;

 private:
  double last_ = std::numeric_limits<double>::quiet_NaN();
};

struct Beside {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware{table, jobs};
  Slow* slow;
  Cycle cycle{0, 1'000'000, 0};

  Beside(Nanoseconds period, bool lock_step, std::counting_semaphore<1000000>* gate = nullptr) {
    auto made = std::make_unique<Slow>();
    slow = made.get();
    slow->gate = gate;
    slow->times.reserve(1 << 20);
    ComponentContext context;
    context.name = "a";
    HostOptions options;
    options.async = true;
    options.period = period;
    options.lock_step = lock_step;
    hardware.add(std::move(made), context, options);
    hardware.configure_and_activate();
    table.seal();
  }
  FaultEvent step() {
    FaultEvent fault = read(hardware, cycle);
    if (!fault) fault = write(hardware, cycle);
    cycle.time += cycle.period;
    ++cycle.index;
    return fault;
  }
  /// Steps until it is so; the loop of these tests runs faster than any clock.
  template <typename So>
  bool until(So so) {
    const Nanoseconds end = realtime::monotonic_now() + 60'000'000'000;
    while (!so() && realtime::monotonic_now() < end) step();
    return so();
  }
};

TEST(OwnClock, InLockStepItIsExchangedInTheFirstCycleNotBeforeItIsDue) {
  Beside b(3'003'003, true);  // 333 Hz
  for (int k = 0; k < 10; ++k) b.step();
  EXPECT_EQ(b.slow->times, (std::vector<Nanoseconds>{0, 4'000'000, 7'000'000}));
  EXPECT_EQ(b.slow->period, 3'003'003);
}

TEST(OwnClock, InLockStepRoundingDoesNotAddUp) {
  for (const auto& [period, in_100_s] :
       {std::pair<Nanoseconds, int>{33'333'333, 3000}, {3'003'003, 33300}, {20'000'000, 5000}}) {
    Beside b(period, true);
    for (int k = 0; k < 100'000; ++k) b.step();
    EXPECT_EQ(b.slow->reads, in_100_s) << period;
  }
}

TEST(OwnClock, InLockStepAFasterOneIsExchangedEveryCycle) {
  Beside b(400'000, true);
  for (int k = 0; k < 100; ++k) b.step();
  EXPECT_EQ(b.slow->reads, 100);
}

TEST(OwnClock, InLockStepCommandsReachItAndStatesComeBackInTheNextCycle) {
  Beside b(5'000'000, true);
  b.table.commands()[0] = 1.5;
  EXPECT_EQ(b.table.states()[0], 0.25);
  b.step();
  b.step();
  EXPECT_EQ(b.table.states()[0], 1.5);
  b.table.commands()[0] = 2.5;
  for (int k = 0; k < 4; ++k) b.step();
  EXPECT_EQ(b.table.states()[0], 1.5) << "its next exchange was in the sixth cycle";
  b.step();
  EXPECT_EQ(b.table.states()[0], 2.5);
}

TEST(OwnClock, AFailureIsToldOnceAndItIsLeftAlone) {
  Beside b(5'000'000, true);
  b.step();
  b.slow->fails = true;
  int faults = 0;
  for (int k = 0; k < 100; ++k) faults += b.step() ? 1 : 0;
  EXPECT_EQ(faults, 1);
  EXPECT_EQ(b.slow->reads, 2);
  b.slow->fails = false;
  b.hardware.run(0, Step::error);
  b.hardware.run(0, Step::configure);
  b.hardware.run(0, Step::activate);
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(b.step());
  EXPECT_EQ(b.slow->reads, 23) << "at once, and every fifth cycle again";
}

TEST(OwnClock, OnTheWallClockItRunsByItselfWhateverTheLoopDoes) {
  Beside b(100'000, false);
  b.table.commands()[0] = 0.75;
  ASSERT_TRUE(b.until([&] { return b.slow->reads >= 50; }));
  EXPECT_TRUE(b.until([&] { return b.table.states()[0] == 0.75; }));
  EXPECT_EQ(b.slow->period, 100'000);
}

TEST(OwnClock, TheLoopNeverWaitsForIt) {
  std::counting_semaphore<1000000> gate{0};
  Beside b(100'000, false, &gate);
  ASSERT_TRUE(b.until([&] { return b.slow->in_call.load(); }));
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(b.step());  // else this would never end
  EXPECT_EQ(b.slow->reads, 0);
  gate.release(1000);
  EXPECT_TRUE(b.until([&] { return b.slow->reads > 0; }));
  gate.release(900);  // whatever it still reads until it is shut down
}

TEST(OwnClock, NobodyCleansUpWhileItReads) {
  std::counting_semaphore<1000000> gate{0};
  Beside b(100'000, false, &gate);
  ASSERT_TRUE(b.until([&] { return b.slow->in_call.load(); }));
  b.hardware.begin_deactivate(0);
  const auto step = b.hardware.begin(0, Step::deactivate);
  step->run();
  b.hardware.finish(*step);
  b.hardware.begin_cleanup(0);
  const auto cleanup = b.hardware.begin(0, Step::cleanup);
  std::thread caller([&] { cleanup->run(); });
  gate.release(1);
  caller.join();
  EXPECT_FALSE(b.slow->in_call_at_cleanup);
  b.hardware.finish(*cleanup);
  EXPECT_EQ(b.hardware.state_of(0), LifecycleState::unconfigured);
  const int reads = b.slow->reads;
  EXPECT_LE(reads, 1) << "and it is left alone from there on";
  gate.release(900);
}

}  // namespace
}  // namespace polyarm::hardware
