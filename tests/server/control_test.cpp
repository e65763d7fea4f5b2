#include "polyarm/server/control.hpp"

#include <gtest/gtest.h>

namespace polyarm::server {
namespace {

using Taken = Control::Taken;
using What = ControlReport::What;

TEST(ControlTest, WhoComesFirstHoldsItAndOnlyOneDoes) {
  Control control;
  EXPECT_FALSE(control.holds(1));
  EXPECT_FALSE(control.holds(0)) << "nobody is not somebody";
  EXPECT_EQ(control.take(1, false, 0), Taken::yes);
  EXPECT_EQ(control.take(1, false, 0), Taken::yes);
  EXPECT_TRUE(control.holds(1));
  EXPECT_FALSE(control.holds(2));
}

TEST(ControlTest, TheHolderIsAskedAndMayRefuse) {
  Control control;
  control.take(1, false, 0);
  EXPECT_EQ(control.take(2, false, 1), Taken::asked);
  EXPECT_TRUE(control.holds(1));
  EXPECT_EQ(control.take(3, false, 1), Taken::others);
  auto news = control.take_reports();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news[0].to, 1u);
  EXPECT_EQ(news[0].what, What::asked);
  EXPECT_FALSE(control.answer(2, true)) << "who asks does not answer";
  EXPECT_TRUE(control.answer(1, false));
  EXPECT_TRUE(control.holds(1));
  news = control.take_reports();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news[0].to, 2u);
  EXPECT_EQ(news[0].what, What::refused);
  control.tick(100);
  EXPECT_TRUE(control.holds(1)) << "who refused keeps it";
}

TEST(ControlTest, TheHolderGivesItOrLosesItByKeepingSilent) {
  Control control;
  control.take(1, false, 0);
  control.take(2, false, 0);
  EXPECT_TRUE(control.answer(1, true));
  EXPECT_TRUE(control.holds(2));
  control.take(1, false, 5);
  control.tick(5 + Control::kTimeout - 0.01);
  EXPECT_TRUE(control.holds(2));
  control.tick(5 + Control::kTimeout);
  EXPECT_TRUE(control.holds(1));
}

TEST(ControlTest, WhoIsGoneLosesItAtOnceToWhoAsks) {
  Control control;
  control.take(1, false, 0);
  control.take(2, false, 0);
  control.gone(1);
  EXPECT_TRUE(control.holds(2));
  control.gone(2);
  EXPECT_EQ(control.holder(), 0u);
  control.take(3, false, 0);
  control.take(4, false, 0);
  control.gone(4);
  control.tick(100);
  EXPECT_TRUE(control.holds(3)) << "who asked is gone";
}

TEST(ControlTest, TakenWithoutAskingTheHolderIsTold) {
  Control control;
  control.take(1, false, 0);
  EXPECT_EQ(control.take(2, true, 0), Taken::yes);
  EXPECT_TRUE(control.holds(2));
  const auto news = control.take_reports();
  ASSERT_EQ(news.size(), 2u);
  EXPECT_EQ(news[0].to, 1u);
  EXPECT_EQ(news[0].what, What::taken);
}

}  // namespace
}  // namespace polyarm::server
