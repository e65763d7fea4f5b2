/// When a follower moves: the clutch, and everything that ends a motion.
#include "polyarm/teleop/teleop_states.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace polyarm::teleop {
namespace {

constexpr TeleopSeen kWell{.held = true, .leader = true, .allowed = true, .taken = true, .matches = true};

TEST(TeleopStatesTest, AClutchThatIsHeldFromTheStartMovesNothing) {
  TeleopPhase phase = TeleopPhase::blocked;
  for (int i = 0; i < 10; ++i) phase = next(phase, kWell);
  EXPECT_EQ(phase, TeleopPhase::blocked);
  phase = next(phase, {});
  EXPECT_EQ(phase, TeleopPhase::waiting);
  phase = next(phase, kWell);
  EXPECT_EQ(phase, TeleopPhase::engaging);
  EXPECT_EQ(next(phase, kWell), TeleopPhase::following);
}

TEST(TeleopStatesTest, FollowsOnlyAfterItHasApproached) {
  TeleopSeen far = kWell;
  far.matches = false;
  TeleopPhase phase = next(TeleopPhase::engaging, far);
  EXPECT_EQ(phase, TeleopPhase::approaching);
  EXPECT_EQ(next(phase, far), TeleopPhase::approaching);
  phase = next(phase, kWell);
  EXPECT_EQ(phase, TeleopPhase::following);
  EXPECT_EQ(next(phase, far), TeleopPhase::following) << "a fast leader is followed, not approached";
}

TEST(TeleopStatesTest, WhateverEndsAMotionNeedsTheClutchAgain) {
  for (const TeleopPhase from : {TeleopPhase::engaging, TeleopPhase::approaching, TeleopPhase::following})
    for (bool TeleopSeen::*lost : {&TeleopSeen::leader, &TeleopSeen::allowed}) {
      TeleopSeen seen = kWell;
      seen.*lost = false;
      TeleopPhase phase = next(from, seen);
      EXPECT_EQ(phase, TeleopPhase::blocked);
      phase = next(phase, kWell);
      EXPECT_EQ(phase, TeleopPhase::blocked) << "the leader is back, and the clutch still held";
    }
}

TEST(TeleopStatesTest, ReleasingTheClutchEndsEverything) {
  for (const TeleopPhase from : {TeleopPhase::blocked, TeleopPhase::waiting, TeleopPhase::engaging,
                                 TeleopPhase::approaching, TeleopPhase::following}) {
    TeleopSeen seen = kWell;
    seen.held = false;
    EXPECT_EQ(next(from, seen), TeleopPhase::waiting);
    EXPECT_FALSE(moves(next(from, seen)));
  }
}

TEST(TeleopStatesTest, ASwitchHasPlay) {
  EXPECT_TRUE(closed_with_play(false, 0.2, 0.25, 0.4));
  EXPECT_FALSE(closed_with_play(false, 0.3, 0.25, 0.4));
  EXPECT_TRUE(closed_with_play(true, 0.3, 0.25, 0.4));
  EXPECT_FALSE(closed_with_play(true, 0.5, 0.25, 0.4));
  EXPECT_FALSE(closed_with_play(false, NAN, 0.25, 0.4));
}

TEST(TeleopStatesTest, ALeaderThatJumpsOrMeasuresNothingIsNotFollowed) {
  LeaderWatch watch;
  const auto look = [&](double before, double now) {
    watch.begin();
    watch.see(before, now);
    return watch.end();
  };
  EXPECT_TRUE(look(0, 3)) << "the first look has nothing before it";
  EXPECT_TRUE(look(3, 3.1));
  EXPECT_FALSE(look(3.1, 3.1 + 2 * LeaderWatch::kJump));
  EXPECT_TRUE(watch.jumped());
  EXPECT_TRUE(look(4, 4));
  EXPECT_FALSE(look(4, NAN));
  EXPECT_FALSE(watch.finite());
  EXPECT_FALSE(look(NAN, INFINITY));
  EXPECT_TRUE(look(NAN, 2)) << "it begins anew";
}

}  // namespace
}  // namespace polyarm::teleop
