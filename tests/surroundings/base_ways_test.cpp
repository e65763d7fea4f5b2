/// Ways of bases: their legs against a slow judge that places the base densely along them.
#include "polyarm/surroundings/base_ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "polyarm/collision/separation.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

using kinematics::Random;
constexpr double kPi = std::numbers::pi, kClearance = 0.01;

/// After driving by `length` along an arc.
BasePlace rolled(const BasePlace& from, double curvature, double length) {
  // The chord of the arc, which points to the middle of its turn.
  const double turn = curvature * length / 2;
  const double chord = turn == 0 ? length : length * std::sin(turn) / turn;
  return {from.x + chord * std::cos(from.heading + turn), from.y + chord * std::sin(from.heading + turn),
          from.heading + 2 * turn};
}

/// 0.6 m long and 0.4 m wide; it turns about a point 0.1 m behind its middle, 0.1 m above the floor.
description::RobotModel cart() {
  description::RobotModel out;
  out.name = "cart";
  out.links.push_back({"base"});
  description::Shape body = box(0.6, 0.4, 0.3);
  body.pose.position = {0.1, 0, 0.25};
  out.links.front().collisions = {body};
  return out;
}

struct Site {
  description::RobotModel model = cart();
  description::Scene scene;
  Moment moment;
  Site() {
    scene.floor = true;
    moment.robots = {{{}, {}}};
  }
  void wall(const std::string& name, const Vec3& size, const Vec3& at, double turn = 0) {
    scene.fixtures.push_back(fixture(name, size, at));
    scene.fixtures.back().pose.rotation = from_rpy(0, 0, turn);
  }
  void stand(double x, double y, double heading) {
    moment.robots.front().base = {{x, y, 0}, from_rpy(0, 0, heading)};
  }
  std::vector<Robot> robots() const { return {{"cart", &model, nullptr, -1, true, {}}}; }
  double sharpest = std::numeric_limits<double>::infinity();
  std::function<bool()> stop;
  BaseWay way(const BasePlace& goal) const {
    BaseWayQuery query;
    query.goal = goal;
    query.clearance = kClearance;
    query.sharpest = sharpest;
    query.stop = stop;
    return find_base_way(robots(), scene, moment, query);
  }
  /// The smallest distance of the cart from all fixtures.
  double room(const BasePlace& at) const {
    const Pose pose{{at.x, at.y, 0}, from_rpy(0, 0, at.heading)};
    double out = std::numeric_limits<double>::infinity();
    for (const auto& mine : collision::bodies_of(model.links.front().collisions.front()))
      for (const description::Fixture& each : scene.fixtures)
        for (const auto& other : collision::bodies_of(each.shapes.front()))
          out = std::min(out, collision::separation(mine, inverse(each.pose) * pose, other).distance);
    return out;
  }
  /// The same along a way, and that its legs join.
  double room(const BaseWay& way, const BasePlace& goal) const {
    double out = std::numeric_limits<double>::infinity();
    const Pose& base = moment.robots.front().base;
    const Vec3 ahead = base.rotation * Vec3{1, 0, 0};
    BasePlace at{base.position.x, base.position.y, std::atan2(ahead.y, ahead.x)};
    for (const BaseLeg& leg : way.legs) {
      EXPECT_NEAR(leg.from.x, at.x, 1e-9);
      EXPECT_NEAR(leg.from.y, at.y, 1e-9);
      EXPECT_NEAR(std::remainder(leg.from.heading - at.heading, 2 * kPi), 0, 1e-9);
      const double turn = std::remainder(leg.to.heading - at.heading, 2 * kPi);
      EXPECT_LE(std::abs(leg.curvature), sharpest + 1e-9);
      EXPECT_TRUE(leg.curvature != 0 || leg.length == 0 || std::abs(turn) < 1e-9) << "a leg turns or drives";
      const int steps = 2 + static_cast<int>(std::max(leg.length / 0.005, std::abs(turn) / 0.01));
      BasePlace here = at;
      for (int k = 0; k <= steps; ++k) {
        here = leg.length == 0
                   ? BasePlace{at.x, at.y, at.heading + turn * k / steps}
                   : rolled(at, leg.curvature, (leg.backwards ? -leg.length : leg.length) * k / steps);
        out = std::min(out, room(here));
      }
      EXPECT_NEAR(here.x, leg.to.x, 1e-6) << "along its heading";
      EXPECT_NEAR(here.y, leg.to.y, 1e-6);
      EXPECT_NEAR(std::remainder(here.heading - leg.to.heading, 2 * kPi), 0, 1e-6);
      at = leg.to;
    }
    EXPECT_NEAR(at.x, goal.x, 1e-3);
    EXPECT_NEAR(at.y, goal.y, 1e-3);
    EXPECT_NEAR(std::remainder(at.heading - goal.heading, 2 * kPi), 0, 1e-5);
    return out;
  }
};

double length_of(const BaseWay& way) {
  double out = 0;
  for (const BaseLeg& leg : way.legs) out += leg.length;
  return out;
}

/// A random site with 12 blocks between the place of the cart and the goal, which is returned.
BasePlace scatter(Site& site, Random& random) {
  for (int k = 0; k < 12; ++k)
    site.wall("w" + std::to_string(k), {random.between(0.1, 1.2), random.between(0.1, 0.4), 1},
              {random.between(-1, 5), random.between(-3, 3), 0.5}, random.between(0, kPi));
  site.stand(-1.5, random.between(-2, 2), random.between(-kPi, kPi));
  return {random.between(4, 5.5), random.between(-2, 2), random.between(-kPi, kPi)};
}

TEST(BaseWays, WithoutObstaclesItTurnsDrivesAndTurns) {
  Site site;
  const BasePlace goal{2, 1, kPi / 2};
  const BaseWay way = site.way(goal);
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_EQ(way.legs.size(), 3u);
  site.room(way, goal);
  EXPECT_NEAR(length_of(way), std::hypot(2, 1), 1e-9);
  EXPECT_TRUE(site.way({0, 0, 0}).legs.empty()) << "it is there";
}

TEST(BaseWays, AShortWayBackIsDrivenBackwards) {
  Site site;
  const BaseWay way = site.way({-0.5, 0, 0});
  ASSERT_EQ(way.legs.size(), 1u);
  EXPECT_TRUE(way.legs.front().backwards);
}

TEST(BaseWays, AroundAWallItIsShortAndKeepsTheClearance) {
  Site site;
  site.wall("wall", {0.1, 2, 1}, {1.5, 0, 0.5});
  const BasePlace goal{3, 0, 0};
  const BaseWay way = site.way(goal);
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GE(site.room(way, goal), kClearance - 1e-6);
  // Around the circles on which the cart can turn freely at the corners of the wall.
  EXPECT_LT(length_of(way), 2 * std::hypot(1.5, 1.65));
}

TEST(BaseWays, WhatIsAboveOrBelowIsNoObstacle) {
  Site site;
  site.wall("bridge", {0.2, 4, 0.2}, {1.5, 0, 0.8});
  site.wall("mat", {1, 1, 0.1}, {1.5, 0, 0.04});
  const BaseWay way = site.way({3, 0, 0});
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_EQ(way.legs.size(), 1u);
  site.wall("low bridge", {0.2, 40, 0.2}, {1.5, 0, 0.45});
  EXPECT_GT(site.way({3, 0, 0}).legs.size(), 1u) << "around its end";
}

TEST(BaseWays, ItDrivesIntoABayInWhichItCannotTurnAndOutAgain) {
  Site site;
  site.wall("left", {1, 0.1, 1}, {3, 0.29, 0.5});
  site.wall("right", {1, 0.1, 1}, {3, -0.29, 0.5});
  site.wall("end", {0.1, 1, 1}, {3.6, 0, 0.5});
  site.stand(1, 2, 0);
  for (const double heading : {0.0, kPi}) {  // ahead and backwards
    const BasePlace goal{heading == 0 ? 3.0 : 3.2, 0, heading};
    const BaseWay in = site.way(goal);
    ASSERT_EQ(in.outcome, BaseWayOutcome::found) << heading;
    EXPECT_GE(site.room(in, goal), kClearance - 1e-6);
    EXPECT_EQ(in.legs.back().backwards, heading != 0);
    Site there = site;
    there.stand(goal.x, goal.y, goal.heading);
    const BasePlace back{1, 2, kPi};
    const BaseWay out = there.way(back);
    ASSERT_EQ(out.outcome, BaseWayOutcome::found) << heading;
    EXPECT_GE(there.room(out, back), kClearance - 1e-6);
    EXPECT_EQ(out.legs.front().backwards, heading == 0);
  }
}

TEST(BaseWays, WhatTouchesAtTheEndsIsNamed) {
  Site site;
  site.wall("post", {0.1, 0.1, 1}, {2.3, 0, 0.5});
  const BaseWay goal = site.way({2, 0, 0});
  EXPECT_EQ(goal.outcome, BaseWayOutcome::goal_touches);
  EXPECT_EQ(goal.other, "fixture post");
  EXPECT_EQ(goal.mine, "cart/base");
  site.stand(2, 0, 0);
  EXPECT_EQ(site.way({0, 0, 0}).outcome, BaseWayOutcome::start_touches);
}

TEST(BaseWays, NearAWallItLeavesWithLessClearance) {
  Site site;
  site.wall("wall", {0.1, 4, 1}, {0.455, 0, 0.5});  // 5 mm before its front
  const BasePlace goal{-1, 0, 0};
  const BaseWay way = site.way(goal);
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GE(site.room(way, goal), 0.8 * 0.005 - 1e-6);
}

TEST(BaseWays, WithoutAWayItSaysSo) {
  Site site;
  for (const double side : {-1.0, 1.0}) {
    site.wall("across", {0.1, 4, 1}, {side * 1.5, 0, 0.5});
    site.wall("along", {3, 0.1, 1}, {0, side * 1.5, 0.5});
  }
  EXPECT_EQ(site.way({3, 0, 0}).outcome, BaseWayOutcome::no_way);
}

TEST(BaseWays, PartsThatLieOnItGoAlongAndOthersAreObstacles) {
  Site site;
  description::Part load;
  load.name = "load";
  load.shape = box(0.5, 0.3, 0.1);
  description::Part crate = load;
  crate.name = "crate";
  crate.shape = box(0.5, 0.5, 0.5);
  site.scene.parts = {load, crate};
  site.moment.parts = {{{{0, 0, 0.45}, {}}, true, -1}, {{{1.5, 0, 0.25}, {}}, true, -1}};
  const BaseWay way = site.way({3, 0, 0});
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GT(way.legs.size(), 1u) << "around the crate";
  site.moment.parts[1].in_world = false;
  EXPECT_EQ(site.way({3, 0, 0}).legs.size(), 1u);
}

TEST(BaseWays, ALoadThatSticksOutKeepsClearOfWalls) {
  Site site;
  site.wall("left", {0.1, 2, 1}, {1.5, 1.4, 0.5});
  site.wall("right", {0.1, 2, 1}, {1.5, -1.4, 0.5});
  EXPECT_EQ(site.way({3, 0, 0}).legs.size(), 1u) << "the cart fits between them";
  description::Part load;
  load.name = "load";
  load.shape = box(0.2, 1.2, 0.1);
  description::Part second = load;
  second.name = "second";
  second.shape = box(0.1, 0.1, 0.1);
  site.scene.parts = {second, load};  // the second one lies on the first
  site.moment.parts = {{{{0, 0, 0.55}, {}}, true, -1}, {{{0, 0, 0.45}, {}}, true, -1}};
  const BaseWay way = site.way({3, 0, 0});
  EXPECT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GT(way.legs.size(), 1u) << "the load does not";
}

TEST(BaseWays, WhatStandsBesideItOnTheGroundIsAnObstacle) {
  Site site;
  description::Part crate;
  crate.name = "crate";
  crate.shape = box(0.5, 0.5, 0.5);
  site.scene.parts.push_back(crate);
  site.moment.parts.push_back({{{0.651, 0, 0.25}, {}}, true, -1});  // 1 mm before its front
  const BaseWay way = site.way({3, 0, 0});
  EXPECT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GT(way.legs.size(), 1u) << "not through it";
}

TEST(BaseWays, AmongRandomObstaclesEveryWayIsFreeAndTheSameAgain) {
  Random random(7);
  int found = 0, around = 0;
  for (int w = 0; w < 16; ++w) {
    Site site;
    const BasePlace goal = scatter(site, random);
    const BaseWay way = site.way(goal);
    if (way.outcome != BaseWayOutcome::found) continue;
    ++found;
    around += way.legs.size() > 3;
    const double room = site.room(way, goal);
    EXPECT_GT(room, 0) << w;
    EXPECT_TRUE(room >= kClearance - 1e-6 || site.room(way.legs.front().from) < kClearance ||
                site.room(goal) < kClearance)
        << w << ": " << room;
    const BaseWay again = site.way(goal);
    ASSERT_EQ(again.legs.size(), way.legs.size());
    for (std::size_t k = 0; k < way.legs.size(); ++k) EXPECT_EQ(again.legs[k].to.x, way.legs[k].to.x);
  }
  EXPECT_GT(found, 10);
  EXPECT_GT(around, 4);
}

TEST(BaseWays, AStoppedSearchEnds) {
  for (const double sharpest : {std::numeric_limits<double>::infinity(), 2.0}) {
    Site site;
    site.sharpest = sharpest;
    site.wall("wall", {0.1, 3, 1}, {1.5, 0, 0.5});
    int asked = 0;
    site.stop = [&] { return ++asked > 3; };
    EXPECT_EQ(site.way({3, 0, 0}).outcome, BaseWayOutcome::out_of_time);
    EXPECT_LT(asked, 10);
  }
}

// ---- bases that steer

TEST(SteeredWays, WithoutObstaclesTheWayIsAShortestOne) {
  Site site;
  site.sharpest = 1;
  EXPECT_EQ(site.way({2, 0, 0}).legs.size(), 1u);
  const BaseWay back = site.way({-0.5, 0, 0});
  ASSERT_EQ(back.legs.size(), 1u);
  EXPECT_TRUE(back.legs.front().backwards);
  const BasePlace goal{3, 1, kPi / 2};
  const BaseWay way = site.way(goal);
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  site.room(way, goal);
  EXPECT_NEAR(length_of(way), 2 + kPi / 2, 1e-6) << "straight, and a quarter turn";
  EXPECT_TRUE(site.way({0, 0, 0}).legs.empty()) << "it is there";
}

TEST(SteeredWays, ItBacksIntoABayAndComesOutAgain) {
  Site site;
  site.sharpest = 1;
  site.wall("left", {1, 0.1, 1}, {3, 0.29, 0.5});
  site.wall("right", {1, 0.1, 1}, {3, -0.29, 0.5});
  site.wall("end", {0.1, 1, 1}, {3.6, 0, 0.5});
  site.stand(1, 2, 0);
  const BasePlace goal{3.2, 0, kPi};
  const BaseWay in = site.way(goal);
  ASSERT_EQ(in.outcome, BaseWayOutcome::found);
  EXPECT_GE(site.room(in, goal), kClearance - 1e-6);
  EXPECT_TRUE(in.legs.back().backwards);
  site.stand(goal.x, goal.y, goal.heading);
  const BasePlace back{1, 2, kPi};
  const BaseWay out = site.way(back);
  ASSERT_EQ(out.outcome, BaseWayOutcome::found);
  EXPECT_GE(site.room(out, back), kClearance - 1e-6);
}

TEST(SteeredWays, ItTurnsRoundBetweenWallsThatAreNearerThanItsCircle) {
  Site site;
  site.sharpest = 1;
  for (const double side : {-1.0, 1.0}) site.wall("along", {8, 0.1, 1}, {0, side * 0.85, 0.5});
  const BasePlace goal{0, 0, kPi};
  const BaseWay way = site.way(goal);
  ASSERT_EQ(way.outcome, BaseWayOutcome::found);
  EXPECT_GE(site.room(way, goal), kClearance - 1e-6);
  EXPECT_GT(way.legs.size(), 3u);
}

TEST(SteeredWays, WithoutAWayItSaysSo) {
  Site site;
  site.sharpest = 1;
  for (const double side : {-1.0, 1.0}) {
    site.wall("across", {0.1, 4, 1}, {side * 1.5, 0, 0.5});
    site.wall("along", {3, 0.1, 1}, {0, side * 1.5, 0.5});
  }
  EXPECT_EQ(site.way({3, 0, 0}).outcome, BaseWayOutcome::no_way);
}

TEST(SteeredWays, AmongRandomObstaclesNoWayHitsNorIsTooSharpAndEachIsTheSameAgain) {
  Random random(11);
  int found = 0, around = 0;
  for (int w = 0; w < 12; ++w) {
    Site site;
    site.sharpest = random.between(0.5, 2);
    const BasePlace goal = scatter(site, random);
    const BaseWay way = site.way(goal);
    if (way.outcome != BaseWayOutcome::found) continue;
    ++found;
    around += way.legs.size() > 5;
    const double room = site.room(way, goal);
    EXPECT_GT(room, 0) << w;
    EXPECT_TRUE(room >= kClearance - 1e-6 || site.room(way.legs.front().from) < kClearance ||
                site.room(goal) < kClearance)
        << w << ": " << room;
    const BaseWay again = site.way(goal);
    ASSERT_EQ(again.legs.size(), way.legs.size());
    for (std::size_t k = 0; k < way.legs.size(); ++k) EXPECT_EQ(again.legs[k].to.x, way.legs[k].to.x);
  }
  EXPECT_GT(found, 6);
  EXPECT_GT(around, 2);
}

}  // namespace
}  // namespace polyarm::surroundings
