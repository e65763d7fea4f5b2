/// Pairs of bodies on their way: what comes near is found, where and when; what grips and places is no
/// contact.
#include "polyarm/surroundings/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/collision/judge.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

class SweepTest : public testing::Test {
 protected:
  SweepTest() : model_(gantry()) { scene_.floor = false; }

  Sweep sweep(double clearance = 0.01) {
    return Sweep({{"arm", &model_, nullptr, -1, false, {}}}, scene_, clearance);
  }
  /// Goes to each place in `steps` moments.
  static void go(Sweep& sweep, double& time, Moment& now, const Vec3& to, int steps) {
    const std::vector<double> from = now.robots[0].joints, end = {to.x, to.y, to.z};
    for (int i = 1; i <= steps; ++i) {
      for (std::size_t j = 0; j < 3; ++j) now.robots[0].joints[j] = from[j] + (end[j] - from[j]) * i / steps;
      for (Moment::PartState& part : now.parts)
        if (part.held_by == 0)
          part.pose.position = {now.robots[0].joints[0], now.robots[0].joints[1],
                                now.robots[0].joints[2] - 0.04};
      sweep.add(now, time += 0.1, {});
    }
  }

  description::RobotModel model_;
  description::Scene scene_;
};

TEST_F(SweepTest, ReportsTheSmallestClearanceAndWhereItIs) {
  scene_.fixtures = {fixture("wall", {0.1, 0.1, 0.1}, {0, 0.1, 0})};  // its face is at y = 0.05
  Sweep work(sweep());
  work.add(at(-0.4, 0.023, 0), 0, {});
  work.add(at(0.4, 0.023, 0), 1, [](std::size_t) { return 7u; });  // 7 mm from the face
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  const Approach& a = work.approaches()[0];
  EXPECT_EQ(a.first, "arm/ball");
  EXPECT_EQ(a.second, "fixture wall");
  EXPECT_NEAR(a.distance, 0.007, Sweep::kResolution);
  EXPECT_NEAR(a.point.y, 0.0465, 0.001);
  EXPECT_NEAR(a.time, 0.5, 0.0626) << "it passes the wall between -0.05 and 0.05";
  EXPECT_EQ(a.mark, 7u);
}

TEST_F(SweepTest, APlateBetweenTwoMomentsIsNotJumpedOver) {
  scene_.fixtures = {fixture("plate", {0.001, 1, 1}, {0.1, 0, 0})};
  Sweep work(sweep(0));
  work.add(at(-1, 0, 0), 0, {});
  work.add(at(1, 0, 0), 1, {});
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_LT(work.approaches()[0].distance, 0);
  EXPECT_NEAR(work.approaches()[0].time, 0.55, 0.011);
}

TEST_F(SweepTest, NothingIsReportedBeyondTheClearance) {
  scene_.fixtures = {fixture("wall", {0.1, 0.1, 0.1}, {0, 0.1, 0})};
  Sweep work(sweep());
  work.add(at(-0.4, 0.0198, 0), 0, {});
  work.add(at(0.4, 0.0198, 0), 1, {});
  work.finish();
  EXPECT_TRUE(work.approaches().empty());
}

TEST_F(SweepTest, AStartInsideSomethingIsSaidAsThat) {
  scene_.fixtures = {fixture("wall", {0.1, 0.1, 0.1}, {0, 0, 0})};
  Sweep work(sweep());
  work.add(at(0.06, 0, 0), 0, {});
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_TRUE(work.approaches()[0].at_start);
  EXPECT_NEAR(work.approaches()[0].distance, -0.01, 2e-4);
  EXPECT_NE(text_of(work.approaches()[0]).find("arm/ball is inside fixture wall where it starts"),
            std::string::npos);
}

TEST_F(SweepTest, AContactKeepsTheMarkUnderWhichItBegan) {
  scene_.fixtures = {fixture("table", {1, 1, 0.1}, {0, 0, -0.07})};  // its face is where the ball ends
  Sweep work(sweep());
  const auto mark = [](std::uint64_t number) { return [number](std::size_t) { return number; }; };
  work.add(at(0, 0, 0.1), 0, mark(1));
  work.add(at(0, 0, 0.005), 1, mark(1));
  work.add(at(0, 0, -0.001), 2, mark(2));  // begins to touch
  work.add(at(0, 0, -0.0015), 3, mark(3));
  work.add(at(0, 0, 0.1), 4, mark(3));
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_EQ(work.approaches()[0].first_mark, 2u);
  EXPECT_NEAR(work.approaches()[0].first_distance, -0.001, 2e-4);
  EXPECT_EQ(work.approaches()[0].mark, 3u);
  EXPECT_NEAR(work.approaches()[0].distance, -0.0015, 2e-4);
}

TEST_F(SweepTest, TheFloorAndAMoverCount) {
  scene_.floor = true;
  scene_.floor_height = -0.5;
  scene_.movers = {{"door", {1, 0, 0}, 0, 1, 0.5, 0.5}};
  scene_.fixtures = {fixture("leaf", {0.1, 0.1, 0.1}, {-1, 0, 0})};
  scene_.fixtures[0].mover = "door";
  Sweep work(sweep());
  Moment now = at(0, 0, 0);
  now.movers = {0};
  work.add(now, 0, {});
  now.movers = {0.5};
  work.add(now, 1, {});
  now.movers = {0.94};  // its face is at -0.01
  work.add(now, 2, {});
  now.movers = {0.5};
  now.robots[0].joints = {0, 0, -0.6};
  work.add(now, 3, {});
  work.finish();
  ASSERT_EQ(work.approaches().size(), 2u);
  EXPECT_EQ(work.approaches()[0].second, "fixture leaf");
  EXPECT_NEAR(work.approaches()[0].distance, -0.01, 2e-4);
  EXPECT_EQ(work.approaches()[1].second, "floor");
  EXPECT_NEAR(work.approaches()[1].distance, -0.12, 1e-9);
}

/// A part of 40 mm on a table, and a post.
class PickTest : public SweepTest {
 protected:
  PickTest() {
    scene_.fixtures = {fixture("table", {1, 1, 0.1}, {0, 0, -0.05}),
                       fixture("post", {0.04, 0.04, 0.3}, {0.2, 0, 0.15})};
    description::Part part;
    part.name = "cube";
    part.shape = box(0.04, 0.04, 0.04);
    scene_.parts = {part};
  }
  Moment begin() const {
    Moment now = at(0, 0, 0.3);
    now.parts = {{{{0, 0, 0.02}, {}}, true, -1}};
    return now;
  }
  void pick(Sweep& work, double& time, Moment& now) {
    work.add(now, time, {});
    go(work, time, now, {0, 0, 0.0605}, 20);  // the ball is 0.5 mm above the part
    now.parts[0].held_by = 0;
    go(work, time, now, {0, 0, 0.0605}, 1);
    go(work, time, now, {0, 0, 0.3}, 20);
  }
};

TEST_F(PickTest, PickingAndPlacingAreNoContacts) {
  Sweep work(sweep());
  Moment now = begin();
  double time = 0;
  pick(work, time, now);
  go(work, time, now, {0, 0.2, 0.3}, 20);
  go(work, time, now, {0, 0.2, 0.06}, 20);
  now.parts[0].held_by = -1;
  go(work, time, now, {0, 0.2, 0.06}, 1);
  go(work, time, now, {0, 0.2, 0.3}, 20);
  work.finish();
  EXPECT_TRUE(work.approaches().empty()) << text_of(work.approaches()[0]);
}

TEST_F(PickTest, AHeldPartBelongsToTheRobot) {
  Sweep work(sweep());
  Moment now = begin();
  double time = 0;
  pick(work, time, now);
  go(work, time, now, {0.4, 0, 0.33}, 3);  // the part passes 10 mm above the post, the ball 30 mm higher
  go(work, time, now, {0, 0, 0.31}, 3);    // and hits it on the way back
  work.finish();
  ASSERT_FALSE(work.approaches().empty());
  const auto deepest = std::min_element(work.approaches().begin(), work.approaches().end(),
                                        [](const auto& a, const auto& b) { return a.distance < b.distance; });
  EXPECT_EQ(deepest->first, "part cube");
  EXPECT_EQ(deepest->second, "fixture post");
  EXPECT_EQ(deepest->robot, 0u);
  EXPECT_LT(deepest->distance, 0);
}

TEST_F(PickTest, APartPressedIntoTheTableIsAContact) {
  Sweep work(sweep());
  Moment now = begin();
  double time = 0;
  pick(work, time, now);
  go(work, time, now, {0, 0.2, 0.3}, 5);
  go(work, time, now, {0, 0.2, 0.056}, 20);
  now.parts[0].held_by = -1;
  go(work, time, now, {0, 0.2, 0.3}, 5);
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_EQ(work.approaches()[0].second, "fixture table");
  EXPECT_NEAR(work.approaches()[0].distance, -0.004, 2e-4);
}

TEST_F(PickTest, ABallThatHitsAPartItDoesNotTakeIsAContact) {
  Sweep work(sweep());
  Moment now = begin();
  double time = 0;
  work.add(now, time, {});
  go(work, time, now, {0, 0, 0.055}, 20);
  go(work, time, now, {0, 0, 0.3}, 20);
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_EQ(work.approaches()[0].second, "part cube");
  EXPECT_NEAR(work.approaches()[0].distance, -0.005, 2e-4);
}

TEST_F(PickTest, AMotionThatEndsInTheMiddleOfAJobMayBeAboutToLetGo) {
  for (const bool holding_on : {false, true}) {
    Sweep work(sweep());
    Moment now = begin();
    double time = 0;
    pick(work, time, now);
    go(work, time, now, {0, 0, 0.061}, 20);
    work.finish(holding_on);
    EXPECT_EQ(work.approaches().empty(), holding_on);
  }
}

TEST(Sweep, TwoRobotsMeet) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  Sweep work({{"left", &model, nullptr, -1, false, {}}, {"right", &model, nullptr, -1, false, {}}}, scene,
             0.01);
  Moment now;
  now.robots = {{{}, {0, 0, 0}}, {{{0.5, 0, 0}, {}}, {0, 0, 0}}};
  work.add(now, 0, {});
  now.robots[0].joints = {0.225, 0, 0};
  now.robots[1].joints = {-0.23, 0, 0};
  work.add(now, 1, {});
  work.finish();
  ASSERT_EQ(work.approaches().size(), 1u);
  EXPECT_EQ(work.approaches()[0].first + work.approaches()[0].second, "left/ballright/ball");
  EXPECT_NEAR(work.approaches()[0].distance, 0.005, Sweep::kResolution);
}

/// Random robots on random ways among random obstacles, against a judge that shares no code with the sweep.
TEST(Sweep, FindsTheSmallestDistanceOfAnyWay) {
  constexpr int kRobots = 40, kMoments = 12, kBetween = 8;
  constexpr double kClearance = 0.03;
  collision::Random random(11);
  int near = 0, touching = 0;
  for (int i = 0; i < kRobots; ++i) {
    const description::RobotModel model = collision::random_robot(random, 6);
    description::Scene scene;
    scene.floor = false;
    const auto shapes = collision::random_world(random, 0.9, 14);
    for (const auto& named : shapes) scene.fixtures.push_back({named.name, {named.shape}, {}, {}, 0.8});
    Robot robot{"arm", &model, nullptr, -1, true, {}};
    robot.body = robot_body(robot);
    collision::Judge judge(model, *robot.body, shapes);
    Sweep sweep({robot}, scene, kClearance);
    std::vector<double> q = collision::random_state(model, random), before = q;
    double judged = 1e9;
    for (int k = 0; k < kMoments; ++k) {
      for (std::size_t j = 0; k > 0 && j < q.size(); ++j) {
        const auto& limits = model.joints[static_cast<std::size_t>(model.actuated[j])].limits;
        q[j] = std::clamp(q[j] + random.between(-0.06, 0.06), *limits.lower, *limits.upper);
      }
      Moment now;
      now.robots = {{{}, q}};
      sweep.add(now, k, {});
      for (int s = 1; s <= kBetween; ++s) {
        std::vector<double> there = before;
        for (std::size_t j = 0; j < q.size(); ++j) there[j] += (q[j] - before[j]) * s / kBetween;
        judged = std::min(judged, judge.distance(there, false).upper);
      }
      before = q;
    }
    sweep.finish();
    double found = 1e9;
    for (const Approach& a : sweep.approaches())  // a robot keeps no clearance from itself
      if (!a.first.starts_with("arm/") || !a.second.starts_with("arm/")) found = std::min(found, a.distance);
    if (judged < kClearance) {
      EXPECT_LE(found, judged + Sweep::kResolution + 1e-5) << "robot " << i;
    }
    if (judged > 0.001 && found < 1e9) {
      EXPECT_GE(found, judged - 0.02) << "robot " << i;
    }
    if (found > kClearance) {
      EXPECT_GE(judged, kClearance - 1e-6) << "robot " << i;
    }
    near += judged < kClearance;
    touching += judged < 1e-4;
  }
  EXPECT_GT(near, 12);
  EXPECT_GT(near - touching, 2);
}

}  // namespace
}  // namespace polyarm::surroundings
