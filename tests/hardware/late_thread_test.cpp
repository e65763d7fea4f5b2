/// A component whose thread does not keep up is told once, and what its options say follows.
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <memory>
#include <semaphore>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/realtime/periodic.hpp"
#include "tests/hardware/exchange_rig.hpp"

namespace polyarm::hardware {
namespace {

using Gate = std::counting_semaphore<1'000'000>;

/// Its reads wait at a gate.
class Gated : public Component {
 public:
  explicit Gated(Gate& gate) : gate_(gate) {}
  CallbackReturn on_init(const ComponentContext&) override { return CallbackReturn::success; }
  std::vector<InterfaceDescription> state_interfaces() const override { return {{"a/j/position", 0.0}}; }
  std::vector<InterfaceDescription> command_interfaces() const override { return {{"a/j/position"}}; }
  ReturnType read(const Cycle&, std::span<double>) noexcept override {
    began.store(realtime::monotonic_now());
    ++entered;
    entered.notify_all();
    gate_.acquire();
    return ReturnType::ok;
  }
  ReturnType write(const Cycle&, std::span<const double>) noexcept override { return ReturnType::ok; }
  static inline std::atomic<int> entered{0};
  static inline std::atomic<Nanoseconds> began{0};

 private:
  Gate& gate_;
};

/// Of own period or triggered; the gate is closed until a test opens it.
struct Late {
  Gate gate{0};
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware{table, jobs};
  Cycle cycle{0, 1'000'000, 0};

  Late(Nanoseconds period, WhenLate when_late) {
    ComponentContext context;
    context.name = "a";
    HostOptions options;
    options.async = true;
    options.period = period;
    options.when_late = when_late;
    options.late_after = 5;
    hardware.add(std::make_unique<Gated>(gate), context, options);
    hardware.configure_and_activate();
    table.seal();
  }
  ~Late() { gate.release(100'000); }
  FaultEvent run(int cycles) {
    FaultEvent seen;
    for (int k = 0; k < cycles; ++k) {
      const FaultEvent first = read(hardware, cycle), second = write(hardware, cycle);
      if (!seen) seen = first ? first : second;
      cycle.time += cycle.period;
      ++cycle.index;
    }
    return seen;
  }
  int told() {
    int count = 0;
    for (std::int32_t who = -1; hardware.diagnostics().take_late(who);) ++count;
    return count;
  }
};

class LateThread : public testing::TestWithParam<Nanoseconds> {};

TEST_P(LateThread, IsReportedOnceAndTheLoopGoesOn) {
  Late late(GetParam(), WhenLate::report);
  EXPECT_FALSE(late.run(4));
  EXPECT_EQ(late.told(), 0) << "not yet";
  EXPECT_FALSE(late.run(1000));
  EXPECT_EQ(late.told(), 1);
  EXPECT_EQ(late.hardware.exchange().fallen(0), StopCause::none);
}

TEST_P(LateThread, AsksTheLoopToHoldOnce) {
  Late late(GetParam(), WhenLate::hold);
  EXPECT_EQ(late.run(1000).cause, StopCause::late);
  EXPECT_FALSE(late.run(1000)) << "once";
  EXPECT_EQ(late.hardware.exchange().fallen(0), StopCause::none);
}

TEST_P(LateThread, IsAFaultOfItsComponentThatSaysWhy) {
  Late late(GetParam(), WhenLate::fault);
  const FaultEvent fault = late.run(1000);
  EXPECT_EQ(fault.cause, StopCause::late);
  EXPECT_EQ(fault.component, 0);
  EXPECT_EQ(late.hardware.exchange().fallen(0), StopCause::late);
  EXPECT_NE(late.hardware.diagnostics().reason(0).find("5 times in a row"), std::string::npos);
  EXPECT_EQ(late.hardware.diagnostics().own_reason(0), "") << "the component itself says nothing";
  EXPECT_EQ(late.hardware.diagnostics().blamed_interface(0), "") << "no single value showed it";
}

INSTANTIATE_TEST_SUITE_P(OfItsOwnPeriodAndTriggered, LateThread,
                         testing::Values(Nanoseconds{1'000'000}, Nanoseconds{0}));

TEST(LateThreads, OneThatWakesLateByTheClockIsLateThoughNoneOfItsTurnsWasMissedByTheLoop) {
  constexpr Nanoseconds kPeriod = 2'000'000;
  Late late(kPeriod, WhenLate::fault);
  int before = Gated::entered;
  late.run(1);  // lets it in; from here on the loop stands still, so that it misses nothing
  for (int k = 0; k < 8; ++k) {
    Gated::entered.wait(before);
    before = Gated::entered;
    while (realtime::monotonic_now() < Gated::began + 2 * kPeriod) {  // its next turn is past
    }
    late.gate.release();
  }
  Gated::entered.wait(before);
  EXPECT_GE(std::uint64_t{late.hardware.diagnostics().thread_health(0)->late}, 7u);
  const FaultEvent fault = late.run(1);
  EXPECT_EQ(fault.cause, StopCause::late);
  EXPECT_EQ(late.told(), 1);
}

TEST(ThreadHealth, CountsWhatItsThreadTellsIt) {
  realtime::ThreadHealth health;
  health.note(1000, 1100, 1400, 1000);
  health.note(2000, 2600, 2700, 1000);
  health.note(3000, 3700, 3800, 1000);
  EXPECT_EQ(health.runs, 3u);
  EXPECT_EQ(health.late, 2u);
  EXPECT_EQ(health.late_in_a_row.load(), 2u);
  EXPECT_EQ(health.wake_up.max(), 700);
  EXPECT_EQ(health.period.max(), 1500);
  EXPECT_EQ(health.period.count(), 2u);
  EXPECT_EQ(health.cost.max(), 300);
  health.note(4000, 4010, 4100, 1000);
  EXPECT_EQ(health.late_in_a_row.load(), 0u);
}

TEST(ThreadHealth, ATriggeredThreadsMissedTurnsAreCountedByTheLoop) {
  Late late(0, WhenLate::report);
  late.run(10);
  EXPECT_EQ(late.hardware.diagnostics().thread_health(0)->missed, 9u);
}

}  // namespace
}  // namespace polyarm::hardware
