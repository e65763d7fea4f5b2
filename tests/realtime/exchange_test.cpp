#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "polyarm/realtime/handover.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/queue.hpp"
#include "polyarm/realtime/stop_latch.hpp"

namespace polyarm::realtime {
namespace {

TEST(Latest, IsNeverTornAndNeverGoesBack) {
  Latest<std::array<long, 64>> latest;
  std::thread writer([&] {
    for (long i = 1; i <= 200000; ++i) {
      latest.draft().fill(i);
      latest.publish();
    }
  });
  long last = 0;
  while (last < 200000) {
    if (!latest.fetch()) continue;
    const auto& value = latest.value();
    ASSERT_GE(value[0], last);
    for (const long x : value) ASSERT_EQ(x, value[0]);
    last = value[0];
  }
  writer.join();
  EXPECT_FALSE(latest.fetch());
}

TEST(Queue, KeepsOrderAndLosesNothing) {
  Queue<int> queue(7);
  std::thread writer([&] {
    for (int i = 0; i < 100000;) i += queue.push(i) ? 1 : 0;
  });
  for (int expected = 0; expected < 100000;) {
    int value = -1;
    if (!queue.pop(value)) continue;
    ASSERT_EQ(value, expected++);
  }
  writer.join();
}

TEST(Queue, SaysWhenItIsFull) {
  Queue<int> queue(2);
  EXPECT_TRUE(queue.push(1));
  EXPECT_TRUE(queue.push(2));
  EXPECT_FALSE(queue.push(3));
}

struct Counted {
  static inline int alive = 0;
  Counted() { ++alive; }
  ~Counted() { --alive; }
};

TEST(Handover, FreesEverythingOnTheBuildersSide) {
  {
    Handover<Counted> handover(4);
    for (int i = 0; i < 10; ++i) {
      auto item = std::make_unique<Counted>();
      if (!handover.give(item)) handover.put_back(handover.take());
    }
    EXPECT_GT(Counted::alive, 0);
  }
  EXPECT_EQ(Counted::alive, 0);
}

TEST(StopLatch, IsNeverWeakened) {
  StopLatch latch;
  latch.request(StopKind::immediate);
  latch.request(StopKind::controlled);
  EXPECT_EQ(latch.requested(), StopKind::immediate);
  latch.clear();
  EXPECT_EQ(latch.requested(), StopKind::none);
}

TEST(Histogram, PercentilesAreWithinABucket) {
  Histogram histogram;
  for (int i = 1; i <= 10000; ++i) histogram.add(i);
  EXPECT_NEAR(static_cast<double>(histogram.percentile(0.5)), 5000, 5000 * 0.07);
  EXPECT_NEAR(static_cast<double>(histogram.percentile(0.99)), 9900, 9900 * 0.07);
  EXPECT_EQ(histogram.max(), 10000);
  histogram.add(INT64_MAX);
  EXPECT_EQ(histogram.percentile(1.0), INT64_MAX);
}

TEST(Histogram, TellsHowSamplesLieByQuartersOfOctaves) {
  Histogram histogram;
  histogram.quarters([](Nanoseconds, std::uint64_t) { FAIL() << "there are none"; });
  for (int i = 1000; i < 3000; ++i) histogram.add(i);
  std::uint64_t count = 0;
  Nanoseconds before = 0;
  int bars = 0;
  histogram.quarters([&](Nanoseconds to, std::uint64_t n) {
    if (bars++ == 0)
      EXPECT_EQ(n, 0u) << "the first says where the shortest begins";
    else
      EXPECT_LT(static_cast<double>(to), 1.26 * static_cast<double>(before));
    const Nanoseconds shortest = std::max<Nanoseconds>(before + 1, 1000),
                      longest = std::min<Nanoseconds>(to, 2999);
    EXPECT_EQ(n, longest < shortest ? 0u : static_cast<std::uint64_t>(longest - shortest + 1)) << to;
    count += n;
    before = to;
  });
  EXPECT_EQ(count, 2000u);
  EXPECT_GE(before, 2999);
  EXPECT_LT(bars, 10);
}

TEST(Histogram, IsReadWhileAnotherThreadAdds) {
  constexpr std::uint64_t kAdded = 200'000;
  Histogram histogram;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kAdded; ++i) histogram.add(static_cast<Nanoseconds>(i % 1000));
  });
  for (std::uint64_t seen = 0; seen < kAdded;) {
    const std::uint64_t now = histogram.count();
    EXPECT_GE(now, seen);
    EXPECT_LE(histogram.percentile(0.5), 999);
    seen = now;
  }
  writer.join();
  EXPECT_EQ(histogram.count(), kAdded);
  EXPECT_EQ(histogram.max(), 999);
}

TEST(Periodic, ReportsWhatItSkippedAndDoesNotCatchUp) {
  Periodic periodic(1'000'000);
  periodic.start();
  periodic.wait();
  const Nanoseconds before = monotonic_now();
  while (monotonic_now() - before < 20'000'000) {
  }
  const WakeUp after_gap = periodic.wait();
  EXPECT_GE(after_gap.skipped, 15u);
  EXPECT_GE(after_gap.latency, 15'000'000);
  const WakeUp next = periodic.wait();
  EXPECT_GT(next.due, before + 20'000'000);
}

}  // namespace
}  // namespace polyarm::realtime
