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

/// As far as the arm can: its speed and its acceleration are limits beside the time.
TEST(PathPlayer, AJointMoveThatStatesItsTimeTakesIt) {
  const auto steps = [](double way, double time) {
    Played arm;
    PlayedMove move;
    move.number = 7;
    move.goal[0] = way;
    move.joint_time = time;
    move.acceleration = 0.5;
    EXPECT_TRUE(arm.player.take(move));
    int out = 0;
    for (; arm.ended.empty() && out < 10'000; ++out) arm.player.step(kStep);
    EXPECT_EQ(arm.q[0], way);
    return out;
  };
  EXPECT_NEAR(steps(1, 2) * kStep, 2, 0.1);
  EXPECT_NEAR(steps(0.1, 3) * kStep, 3, 0.15);
  EXPECT_GT(steps(10, 0.5) * kStep, 2) << "no faster than 5 rad/s";
}

}  // namespace
}  // namespace polyarm::forward
