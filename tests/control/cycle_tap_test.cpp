#include "polyarm/control/cycle_tap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <thread>

#include "polyarm/control/control_loop.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::control {
namespace {

TEST(CycleTap, GivesEveryRowOnceAndInOrderToAnotherThread) {
  constexpr std::uint64_t kRows = 200'000;
  CycleTap tap(2, 1, 64);
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < kRows;) {
      const std::array<double, 2> states{static_cast<double>(i), -static_cast<double>(i)};
      const std::array<double, 1> commands{0.5 * static_cast<double>(i)};
      TappedCycle cycle;
      cycle.index = i;
      const std::uint64_t lost = tap.lost();
      tap.record(cycle, states, commands);
      if (tap.lost() == lost) ++i;
    }
  });
  for (std::uint64_t i = 0; i < kRows;) {
    const TappedCycle* row = tap.front();
    if (!row) continue;
    ASSERT_EQ(row->index, i);
    ASSERT_EQ(tap.states()[0], static_cast<double>(i));
    ASSERT_EQ(tap.states()[1], -static_cast<double>(i));
    ASSERT_EQ(tap.commands()[0], 0.5 * static_cast<double>(i));
    tap.drop();
    ++i;
  }
  writer.join();
  EXPECT_EQ(tap.front(), nullptr);
}

TEST(CycleTap, CountsWhatFindsNoRoomAndKeepsTheOldest) {
  CycleTap tap(1, 0, 3);
  for (std::uint64_t i = 0; i < 5; ++i) {
    const std::array<double, 1> states{static_cast<double>(i)};
    TappedCycle cycle;
    cycle.index = i;
    tap.record(cycle, states, {});
  }
  EXPECT_EQ(tap.lost(), 2u);
  ASSERT_NE(tap.front(), nullptr);
  EXPECT_EQ(tap.front()->index, 0u);
}

TEST(CycleTap, TakesOneOfSoManyCyclesOfARunningLoopWithoutAllocating) {
  ControlLoop loop{LoopOptions{}};
  loop.supervisor().watch_cell = false;
  loop.start_hardware();
  loop.prepare({});
  loop.begin();
  const auto tap = loop.make_tap(100, 10);
  loop.tap(tap.get());
  for (int i = 0; i < 20; ++i) loop.step_next();
  while (tap->front()) tap->drop();
  const Nanoseconds before = loop.cycle().time;
  {
    const test::RealtimeGuard guard;
    for (int i = 0; i < 500; ++i) loop.step_next();
    EXPECT_TRUE(guard.violations().empty() || !test::RealtimeGuard::watches()) << guard.violations();
  }
  int rows = 0;
  for (; tap->front(); tap->drop(), ++rows) {
    EXPECT_EQ(tap->front()->index % 10, 0u);
    EXPECT_GE(tap->front()->time, before);
  }
  EXPECT_EQ(rows, 50);
  const auto away = loop.tap(nullptr);
  loop.step_next();
  ASSERT_TRUE(away->done());
  for (int i = 0; i < 50; ++i) loop.step_next();
  EXPECT_EQ(tap->front(), nullptr) << "nothing comes any more";
}

}  // namespace
}  // namespace polyarm::control
