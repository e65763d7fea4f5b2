/// What a look along a planned way finds, against many samples of it.
#include "polyarm/surroundings/look_ahead.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/collision/judge.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

using kinematics::Random;

/// Straight in joint space, at a constant rate.
class Straight : public PlannedWay {
 public:
  Straight(std::vector<double> from, std::vector<double> to, double duration)
      : from_(std::move(from)), to_(std::move(to)), acceleration_(from_.size(), 1.0), duration_(duration) {}
  double duration() const noexcept override { return duration_; }
  void at(double time, std::span<double> q, std::span<double> v) noexcept override {
    const double s = std::clamp(time / duration_, 0.0, 1.0);
    for (std::size_t j = 0; j < from_.size(); ++j) {
      if (!q.empty()) q[j] = from_[j] + s * (to_[j] - from_[j]);
      if (!v.empty()) v[j] = (to_[j] - from_[j]) / duration_;
    }
  }
  std::span<const double> acceleration() const noexcept override { return acceleration_; }

 private:
  std::vector<double> from_, to_, acceleration_;
  double duration_;
};

struct ClutteredCell {
  ClutteredCell(Random& random, int obstacles) : model(collision::random_robot(random, 6)) {
    scene.floor = false;
    for (const collision::NamedShape& one : collision::random_world(random, 1.3, obstacles)) {
      description::Fixture fixture;
      fixture.name = one.name;
      fixture.shapes = {one.shape};
      scene.fixtures.push_back(fixture);
    }
  }
  Moment at(const std::vector<double>& q) const {
    Moment out;
    out.robots = {{{}, q}};
    return out;
  }
  description::RobotModel model;
  description::Scene scene;
};

double room(GuardBodies& bodies, double clearance) {
  double out = 1e9;
  for (const GuardPair& pair : bodies.pairs())
    if (pair.active) out = std::min(out, bodies.gap_of(pair, 1e9).distance - (pair.own ? 0 : clearance));
  return out;
}

TEST(LookAhead, NothingNearerThanTheClearanceIsOnTheWayThatItCallsFree) {
  constexpr double kClearance = 0.01;
  Random random(11);
  int ways = 0, blocked = 0, early = 0;
  for (int w = 0; w < 40; ++w) {
    ClutteredCell cell(random, 6);
    const Robot robot{"arm", &cell.model, nullptr, -1, true, {}};
    GuardBodies bodies({robot}, cell.scene), exact({robot}, cell.scene);
    LookAhead ahead(bodies, 0, {kClearance, 0.7, 5000});
    for (int i = 0; i < 6; ++i) {
      const std::vector<double> from = collision::random_state(cell.model, random),
                                to = collision::random_state(cell.model, random);
      exact.look(cell.at(from));
      if (room(exact, kClearance) < 0.01) continue;
      exact.look(cell.at(to));
      if (room(exact, kClearance) < 0.01) continue;
      ++ways;
      Straight way(from, to, 2);
      bodies.look(cell.at(from));
      ahead.begin(way, {});
      const std::vector<std::vector<double>> nobody(1, std::vector<double>(from.size(), 0.0));
      const LookAhead::Answer answer = ahead.look(way, 0, 2, nobody);
      constexpr int kSamples = 400;
      double first = INFINITY;
      std::vector<double> q(from.size());
      for (int k = 0; k <= kSamples && first > 2; ++k) {
        way.at(2.0 * k / kSamples, q, {});
        exact.look(cell.at(q));
        const double here = room(exact, kClearance);
        if (here < 0) first = 2.0 * k / kSamples;
        if (2.0 * k / kSamples < answer.free_until) ASSERT_GE(here, -0.001) << w << " " << i << " " << k;
      }
      blocked += std::isfinite(first);
      if (std::isfinite(answer.free_until)) {
        ASSERT_GE(answer.pair, 0);
        early += answer.free_until < first - 0.02;
      }
    }
  }
  EXPECT_GT(ways, 40);
  EXPECT_GT(blocked, 10);
  EXPECT_LE(early, ways / 20) << "false alarms";
  std::printf("%d ways, %d blocked, %d early\n", ways, blocked, early);
}

TEST(LookAhead, AGoalNearSomethingMayBeReached) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  scene.fixtures = {fixture("wall", {0.1, 1, 1}, {0.5, 0, 0})};  // its face is at x = 0.45
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  LookAhead ahead(bodies, 0, {});
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(3, 0.0));
  const auto free_until = [&](double to) {
    Straight way({0, 0, 0}, {to, 0, 0}, 1);
    bodies.look(at(0, 0, 0));
    ahead.begin(way, {});
    return ahead.look(way, 0, 1, nobody).free_until;
  };
  EXPECT_TRUE(std::isinf(free_until(0.40)));
  EXPECT_TRUE(std::isinf(free_until(0.429))) << "1 mm before the wall, where somebody taught it";
  const double hit = free_until(0.44);  // 10 mm inside
  EXPECT_NEAR(hit * 0.44, 0.43, 0.001) << "up to the wall";
  EXPECT_NEAR(free_until(0.8) * 0.8, 0.425, 0.002)
      << "the clearance before the wall; beyond it nothing is near";
}

/// More is near than one look can measure: what is found stays known, so the next looks know all of it.
TEST(LookAhead, AWayAmongMoreBodiesThanALookCanMeasureIsKnownLater) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  for (int i = 0; i < 60; ++i)
    scene.fixtures.push_back(fixture("post_" + std::to_string(i), {0.005, 0.02, 0.1},
                                     {0.01 * (i / 2), i % 2 == 0 ? 0.1 : -0.1, 0}));
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  LookAheadOptions options;
  options.most_measured = 5, options.at_first = 1;
  LookAhead ahead(bodies, 0, options);
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(3, 0.0));
  Straight way({0, 0, 0}, {0.3, 0, 0}, 1);
  bodies.look(at(0, 0, 0));
  ahead.begin(way, {});
  LookAhead::Answer answer = ahead.look(way, 0, 1, nobody);
  EXPECT_EQ(answer.free_until, 0) << "not all is known";
  EXPECT_EQ(answer.pair, -1);
  int looks = 1;
  for (; looks < 200 && std::isfinite(answer.free_until); ++looks) {
    bodies.look(at(0, 0, 0));
    answer = ahead.look(way, 0, 1, nobody);
  }
  EXPECT_TRUE(std::isinf(answer.free_until)) << "after " << looks << " looks";
}

TEST(LookAhead, AStartInsideSomethingMayBeLeft) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  scene.fixtures = {fixture("wall", {0.1, 1, 1}, {0.5, 0, 0})};
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  LookAhead ahead(bodies, 0, {});
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(3, 0.0));
  Straight out({0.435, 0, 0}, {0.2, 0, 0}, 1), in({0.435, 0, 0}, {0.5, 0, 0}, 1);
  bodies.look(at(0.435, 0, 0));
  ahead.begin(out, {});
  EXPECT_TRUE(std::isinf(ahead.look(out, 0, 1, nobody).free_until));
  ahead.begin(in, {});
  EXPECT_LT(ahead.look(in, 0, 1, nobody).free_until, 0.02);
}

TEST(LookAhead, AToolThatIsMeantToTouchMayAndTheRestOfTheArmMayNot) {
  const description::RobotModel model = gantry();
  description::Tool tool;
  tool.body = {box(0.01, 0.01, 0.01)};
  tool.body[0].pose.position = {0.03, 0, 0};  // ahead of the ball
  description::Scene scene;
  scene.floor = false;
  scene.fixtures = {fixture("wall", {0.1, 1, 1}, {0.5, 0, 0})};
  GuardBodies bodies({{"arm", &model, &tool, -1, false, {}}}, scene);
  LookAhead ahead(bodies, 0, {});
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(3, 0.0));
  Straight way({0, 0, 0}, {0.8, 0, 0}, 1);
  bodies.look(at(0, 0, 0));
  const std::vector<TouchTime> meant{{0, 1}};
  const auto free_until = [&](bool touch) {
    ahead.begin(way, {}, touch ? std::span<const TouchTime>(meant) : std::span<const TouchTime>());
    return 0.8 * ahead.look(way, 0, 1, nobody).free_until;
  };
  EXPECT_NEAR(free_until(false), 0.41, 0.002) << "the tool keeps the clearance";
  EXPECT_NEAR(free_until(true), 0.425, 0.002) << "the ball does";
  EXPECT_NEAR(free_until(false), 0.41, 0.002) << "and the tool again";
}

TEST(LookAhead, AnObstacleThatComesIsSeenAndOneThatLeavesIsForgotten) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  description::Mover mover;
  mover.name = "gate";
  mover.axis = {0, 0, 1};
  scene.movers = {mover};
  scene.fixtures = {fixture("gate", {0.1, 1, 0.2}, {0.5, 0, 1})};
  scene.fixtures[0].mover = "gate";
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  LookAhead ahead(bodies, 0, {});
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(3, 0.0));
  Straight way({0, 0, 0}, {1, 0, 0}, 1);
  Moment moment = at(0, 0, 0);
  const auto free_until = [&](double gate) {
    moment.movers = {gate};
    bodies.look(moment);
    return ahead.look(way, 0, 1, nobody).free_until;
  };
  moment.movers = {0};
  bodies.look(moment);
  ahead.begin(way, {});
  EXPECT_TRUE(std::isinf(free_until(0)));
  EXPECT_NEAR(free_until(-1), 0.425, 0.002);
  EXPECT_NEAR(free_until(-1), 0.425, 0.002) << "also when it stands";
  EXPECT_TRUE(std::isinf(free_until(-0.5)));
}

/// A cube of 40 mm that hangs below the ball, over a shelf that moves up and down.
struct PutDown {
  PutDown() : model(gantry()) {
    tool.body = {box(0.004, 0.004, 0.004)};
    scene.floor = false;
    description::Part cube;
    cube.name = "cube";
    cube.shape = box(0.04, 0.04, 0.04);
    scene.parts = {cube};
    description::Mover lift;
    lift.name = "lift";
    lift.axis = {0, 0, 1};
    scene.movers = {lift};
    scene.fixtures = {fixture("shelf", {1, 1, 0.1}, {0, 0, -0.05})};  // its top is at z = 0
    scene.fixtures[0].mover = "lift";
    moment = at(0, 0, kHigh);
    moment.movers = {0};
    moment.parts = {{{{0, 0, kHigh - 0.05}, {}}, true, 0}};
    bodies = std::make_unique<GuardBodies>(std::vector<Robot>{{"arm", &model, &tool, -1, false, {}}}, scene);
    ahead = std::make_unique<LookAhead>(*bodies, 0, LookAheadOptions{});
  }
  /// How near the cube comes to the shelf, as planned, on a way that ends `gap` above it and at which the
  /// shelf is `lift` higher than when it began; the gap at which it would stop, or at the end.
  double nearest(double gap, double lift) {
    const double end = gap + 0.07;
    Straight way({0, 0, kHigh}, {0, 0, end}, 1);
    moment.movers = {0};
    bodies->look(moment);
    ahead->begin(way, {});
    moment.movers = {lift};
    bodies->look(moment);
    const double until = std::min(1.0, ahead->look(way, 0, 1, nobody).free_until);
    return kHigh + until * (end - kHigh) - 0.07 - lift;
  }
  static constexpr double kHigh = 0.5;
  description::RobotModel model;
  description::Tool tool;
  description::Scene scene;
  Moment moment;
  std::unique_ptr<GuardBodies> bodies;
  std::unique_ptr<LookAhead> ahead;
  const std::vector<std::vector<double>> nobody = std::vector(1, std::vector<double>(3, 0.0));
};

/// A part that a move puts down may touch what it is put on, and no move goes deeper than pressing.
TEST(LookAhead, APartIsPutDownWhereAMoveEndsAndNotDeeper) {
  PutDown cell;
  EXPECT_NEAR(cell.nearest(0, 0), 0, 1e-6) << "down to the shelf";
  EXPECT_NEAR(cell.nearest(0.0075, 0), 0.0075, 1e-6) << "a little above it";
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const double gap = random.between(-0.02, 0.0079);  // nearer than clearance and inexactness
    ASSERT_NEAR(cell.nearest(gap, 0), std::max(gap, -LookAhead::kPressing), 1e-3) << gap;
  }
}

/// Grips and movers are not exact: a place that is nearer than planned by less than this is still reached.
TEST(LookAhead, APlaceThatIsNotQuiteWhereItWasIsReached) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    PutDown cell;
    const double gap = random.between(0, 0.0079), lift = random.between(0, 0.003);
    ASSERT_NEAR(cell.nearest(gap, lift), std::max(gap - lift, -LookAhead::kPressing), 1e-3)
        << gap << " " << lift;
  }
}

TEST(LookAhead, TwoRobotsCountHowFarTheOtherStillGoes) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  GuardBodies bodies({{"left", &model, nullptr, -1, true, {}}, {"right", &model, nullptr, -1, true, {}}},
                     scene);
  LookAhead ahead(bodies, 0, {});
  Moment moment;
  moment.robots = {{{}, {0, 0, 0}}, {{{1, 0, 0}, {}}, {0, 0, 0}}};
  Straight way({0, 0, 0}, {1, 0, 0}, 1);
  bodies.look(moment);
  ahead.begin(way, {});
  std::vector<std::vector<double>> stopping(2, std::vector<double>(3, 0.0));
  const double still = ahead.look(way, 0, 1, stopping).free_until;
  stopping[1][0] = 0.3;
  EXPECT_NEAR(ahead.look(way, 0, 1, stopping).free_until, still - 0.3, 0.002);
  stopping[1][0] = 0;
  EXPECT_NEAR(ahead.look(way, 0, 1, stopping).free_until, still, 0.002) << "it stands again";
  moment.robots[1].joints[0] = -0.2;
  bodies.look(moment);
  EXPECT_NEAR(ahead.look(way, 0, 1, stopping).free_until, still - 0.2, 0.002) << "it has come nearer";
}

TEST(LookAhead, AWayAmongMoreRobotsThanALookCanMeasureIsKnownLater) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  std::vector<Robot> robots;
  Moment moment;
  for (int i = 0; i < 13; ++i) {
    robots.push_back({"robot_" + std::to_string(i), &model, nullptr, -1, true, {}});
    moment.robots.push_back({{{0.05 * (i / 2), i == 0 ? 0 : i % 2 == 0 ? 0.1 : -0.1, 0}, {}}, {0, 0, 0}});
  }
  GuardBodies bodies(robots, scene);
  LookAheadOptions options;
  options.most_measured = 3, options.at_first = 1;
  LookAhead ahead(bodies, 0, options);
  const std::vector<std::vector<double>> stopping(robots.size(), std::vector<double>(3, 0.0));
  Straight way({0, 0, 0}, {0.3, 0, 0}, 1);
  bodies.look(moment);
  ahead.begin(way, {});
  EXPECT_EQ(ahead.look(way, 0, 1, stopping).pair, -1) << "not all is known";
  double free_until = 0;
  for (int looks = 0; looks < 200 && std::isfinite(free_until); ++looks) {
    bodies.look(moment);
    free_until = ahead.look(way, 0, 1, stopping).free_until;
  }
  EXPECT_TRUE(std::isinf(free_until));
}

TEST(LookAhead, AllocatesNothing) {
  Random random(12);
  ClutteredCell cell(random, 40);
  GuardBodies bodies({{"arm", &cell.model, nullptr, -1, true, {}}}, cell.scene);
  LookAhead ahead(bodies, 0, {});
  Straight way(collision::random_state(cell.model, random), collision::random_state(cell.model, random), 2);
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(bodies.variables(0), 0.0));
  Moment moment = cell.at(collision::random_state(cell.model, random));
  bodies.look(moment);
  ahead.begin(way, {});
  std::string violations;
  {
    test::RealtimeGuard guard;
    for (int i = 0; i < 500; ++i) {
      way.at(0.002 * i, moment.robots[0].joints, {});
      bodies.look(moment);
      ahead.look(way, 0.002 * i, 0.002 * i + 0.4, nobody);
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm::surroundings
