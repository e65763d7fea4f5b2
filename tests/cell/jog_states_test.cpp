/// The states of a robot that is jogged, as a table, and the dead-man rule.
#include "polyarm/operation/jog_states.hpp"

#include <gtest/gtest.h>

#include <array>

namespace polyarm::cell {
namespace {

using enum JogPhase;

TEST(JogStates, AreThisTable) {
  constexpr std::array kFrom{idle, switching, moving, releasing};
  constexpr JogPhase kTo[5][4] = {
      // idle       switching  moving     releasing
      {switching, switching, moving, releasing},  // asked
      {idle, moving, moving, idle},               // switched
      {idle, idle, moving, idle},                 // refused
      {idle, switching, releasing, releasing},    // expired
      {idle, idle, idle, idle},                   // lost
  };
  for (int change = 0; change < 5; ++change)
    for (std::size_t from = 0; from < kFrom.size(); ++from)
      EXPECT_EQ(next(kFrom[from], static_cast<JogChange>(change)), kTo[change][from])
          << "change " << change << " from " << from;
}

TEST(JogStates, TheJogControllerHasTheJointsUntilTheyAreGivenBack) {
  EXPECT_FALSE(has_joints(idle));
  EXPECT_FALSE(has_joints(switching));
  EXPECT_TRUE(has_joints(moving));
  EXPECT_TRUE(has_joints(releasing));
}

TEST(DeadMan, ExpiresWhenNothingRenewsItForTheTimeThatACommandIsGoodFor) {
  DeadMan dead_man;
  dead_man.renew(1000, 120);
  EXPECT_FALSE(dead_man.expired(1120));
  EXPECT_TRUE(dead_man.expired(1121));
  EXPECT_FALSE(dead_man.expired(1121, 10)) << "10 more";
  dead_man.renew(1121, 120);
  EXPECT_FALSE(dead_man.expired(1241));
  dead_man.release_now(1241, 300);
  EXPECT_TRUE(dead_man.expired(1241));
}

}  // namespace
}  // namespace polyarm::cell
