#include "drivers/forward/readings.hpp"

#include <gtest/gtest.h>

namespace polyarm::forward {
namespace {

TEST(Readings, GoStraightFromOneToTheNextOneReadingBehind) {
  Readings readings;
  hardware::Cycle cycle{0, 4'000'000, 0};
  const auto read = [&](double q, std::uint64_t count) {
    cycle.time += cycle.period;
    return readings.at({q}, count, cycle)[0];
  };
  EXPECT_EQ(read(1, 1), 1) << "the first one as it is";
  for (int i = 0; i < 4; ++i) read(1, 1);
  double before = 1;
  for (int i = 0; i < 5; ++i) {
    const double at = read(2, 2);
    EXPECT_GT(at, before);
    EXPECT_LE(at, 2);
    before = at;
  }
  EXPECT_NEAR(before, 2, 1e-9);
  EXPECT_EQ(read(5, 1), 5) << "a new connection begins anew";
  EXPECT_EQ(readings.shown()[0], 5);
}

}  // namespace
}  // namespace polyarm::forward
