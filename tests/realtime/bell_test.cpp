#include "polyarm/realtime/bell.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {
namespace {

constexpr Nanoseconds kLong = 600'000'000'000;

TEST(Bell, WakesWhoWaitsLongBeforeItIsDue) {
  Bell bell;
  std::thread other([&] { bell.ring(); });
  EXPECT_TRUE(bell.wait_until(monotonic_now() + kLong));
  other.join();
}

TEST(Bell, WhatWasRungWhileNobodyWaitedCountsOnce) {
  Bell bell;
  bell.ring();
  bell.ring();
  EXPECT_TRUE(bell.wait_until(monotonic_now() + kLong));
  EXPECT_FALSE(bell.wait_until(monotonic_now()));
}

TEST(Bell, NobodyRingsAndItIsDue) {
  Bell bell;
  const Nanoseconds due = monotonic_now() + 1'000'000;
  EXPECT_FALSE(bell.wait_until(due));
  EXPECT_GE(monotonic_now(), due);
}

TEST(WakeupHandle, RingsTheBellThatItIsTiedToAndNoOther) {
  const auto first = std::make_shared<Bell>(), second = std::make_shared<Bell>();
  WakeupHandle rope;
  rope.pull();  // nobody hears it
  rope.tie(first);
  rope.tie(second);
  rope.pull();
  EXPECT_FALSE(first->wait_until(0));
  EXPECT_TRUE(second->wait_until(0));
  rope.tie(nullptr);
  rope.pull();
  EXPECT_FALSE(second->wait_until(0));
}

}  // namespace
}  // namespace polyarm::realtime
