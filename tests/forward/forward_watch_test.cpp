/// Whose commands the joints of a robot get that makes its own moves.
#include "drivers/wire/forward_watch.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace polyarm::forward_watch_test {
namespace {

using wire::Six;

struct Watched {
  Watched() { watch.begin(); }
  std::optional<int> strays(double command, double measured) {
    const Six commands{0, 0, command, 0, 0, 0}, at{0, 0, measured, 0, 0, 0};
    return watch.strays(commands, at);
  }
  wire::ForwardWatch watch;
};

TEST(ForwardWatch, ACommandThatLeavesTheMeasuredPlaceIsAStrangers) {
  Watched arm;
  EXPECT_EQ(arm.strays(0, 0), std::nullopt);
  for (int k = 1; k < 10; ++k) EXPECT_EQ(arm.strays(0.01 * k, 0), std::nullopt);
  EXPECT_EQ(arm.strays(0.101, 0), 2);
  EXPECT_EQ(Watched{}.strays(0.5, 0), 2) << "the first command";
  EXPECT_EQ(Watched{}.strays(0.05, 0), std::nullopt);
}

/// Behind a gap the measured joint has gone further than limits let a command go in a cycle.
TEST(ForwardWatch, ACommandThatComesNearerIsOnlyLate) {
  Watched arm;
  EXPECT_EQ(arm.strays(0, 0), std::nullopt);
  for (int k = 1; k <= 50; ++k) EXPECT_EQ(arm.strays(0.006 * k, 0.3), std::nullopt) << k;
  EXPECT_EQ(arm.strays(0.3, 0.3), std::nullopt);
  EXPECT_EQ(arm.strays(0.15, 0.3), 2) << "and away again";
}

}  // namespace
}  // namespace polyarm::forward_watch_test
