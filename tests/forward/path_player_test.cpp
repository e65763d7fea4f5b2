#include "drivers/forward/path_player.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace polyarm::forward {
namespace {

constexpr double kStep = 0.016;  // s

/// An arm that is where it was told to be, with a player for it.
struct Played {
  Six q{};
  std::vector<int> ended;
  PathPlayer player{{.q = [this]() -> const Six& { return q; },
                     .still = [] { return true; },
                     .may_move = [] { return true; },
                     .follow = [this](const Six& to) { q = to; },
                     .refuse = [] { FAIL() << "the arm can follow"; },
                     .ended = [this](int number) { ended.push_back(number); },
                     .flange = [](const Six&, std::array<double, 36>& J) { return J.fill(0), Pose{}; },
                     .velocity = {5, 5, 5, 5, 5, 5},
                     .acceleration = {30, 30, 30, 30, 30, 30}},
                    4};
  void turn(double to, double share) {
    PlayedMove move;
    move.number = 7;
    move.goal[0] = to;
    move.share = share;
    move.acceleration = 1;
    ASSERT_TRUE(player.take(move));
  }
};

/// In one step the acceleration alone would bring it to 0.48 rad/s.
TEST(PathPlayer, AMoveThatIsSlowerThanOneStepOfAccelerationKeepsItsSpeedAndArrives) {
  Played arm;
  arm.turn(0.1, 0.01);
  for (int i = 0; i < 100; ++i) arm.player.step(kStep);
  EXPECT_NEAR(arm.q[0], 0.05 * 100 * kStep, 2e-3);
  EXPECT_TRUE(arm.ended.empty());
  for (int i = 0; i < 40; ++i) arm.player.step(kStep);
  EXPECT_EQ(arm.q[0], 0.1);
  EXPECT_EQ(arm.ended, std::vector{7});
}

}  // namespace
}  // namespace polyarm::forward
