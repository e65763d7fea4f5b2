/// Distances and bounds of guards, against a slow exact judge and against numbers.
#include "polyarm/surroundings/guard_bodies.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/collision/judge.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

using collision::NamedShape;
using kinematics::Random;

/// A random robot in a random world, which it is not fixed to: every link counts.
struct RandomCell {
  explicit RandomCell(Random& random, int obstacles = 12) : model(collision::random_robot(random, 6)) {
    scene.floor = false;
    world = collision::random_world(random, 1.2, obstacles);
    for (const NamedShape& one : world) {
      description::Fixture fixture;
      fixture.name = one.name;
      fixture.shapes = {one.shape};
      scene.fixtures.push_back(fixture);
    }
    robot = {"arm", &model, nullptr, -1, true, {}};
    robot.body = robot_body(robot);
  }
  Moment at(const std::vector<double>& q) const {
    Moment out;
    out.robots = {{{}, q}};
    return out;
  }
  description::RobotModel model;
  description::Scene scene;
  std::vector<NamedShape> world;
  Robot robot;
};

TEST(GuardBodies, TheSmallestDistanceIsThatOfASlowJudge) {
  Random random(5);
  int near = 0;
  for (int w = 0; w < 12; ++w) {
    RandomCell cell(random);
    GuardBodies bodies({cell.robot}, cell.scene);
    collision::Judge judge(cell.model, *cell.robot.body, cell.world);
    for (int i = 0; i < 25; ++i) {
      const std::vector<double> q = collision::random_state(cell.model, random);
      bodies.look(cell.at(q));
      double least = 1e9;
      for (std::size_t p = 0; p < bodies.pairs().size(); ++p) least = std::min(least, bodies.measure(p, 1e9));
      const collision::Bracket truth = judge.distance(q);
      EXPECT_LE(least, truth.upper + 1e-5) << w << " " << i;
      if (truth.lower > 0) {
        EXPECT_GE(least, truth.lower - 1e-5) << w << " " << i;
      }
      near += truth.lower > 0 && truth.upper < 0.1;
    }
  }
  EXPECT_GT(near, 20);
}

TEST(GuardBodies, WhatIsKnownOfADistanceIsNeverMoreThanTheDistance) {
  Random random(6);
  for (int w = 0; w < 10; ++w) {
    RandomCell cell(random);
    GuardBodies bodies({cell.robot}, cell.scene);
    std::vector<double> q = collision::random_state(cell.model, random);
    bodies.look(cell.at(q));
    for (std::size_t p = 0; p < bodies.pairs().size(); ++p) bodies.measure(p, 1e9);
    for (int i = 0; i < 40; ++i) {
      for (double& x : q) x += random.between(-0.03, 0.03);
      bodies.look(cell.at(q));
      for (const GuardPair& pair : bodies.pairs())
        if (const double distance = bodies.gap_of(pair, 1e9).distance; distance > 0)
          ASSERT_LE(pair.slack, distance + 1e-9) << bodies.name(pair.a) << " " << bodies.name(pair.b);
    }
  }
}

TEST(GuardBodies, TheGradientIsTheChangeOfTheDistance) {
  Random random(7);
  int compared = 0, differ = 0;
  for (int w = 0; w < 12; ++w) {
    RandomCell cell(random);
    GuardBodies bodies({cell.robot}, cell.scene);
    const std::vector<double> q = collision::random_state(cell.model, random);
    bodies.look(cell.at(q));
    std::vector<double> gradient(q.size()), moved = q;
    for (const GuardPair& pair : bodies.pairs()) {
      const GuardGap gap = bodies.gap_of(pair, 1e9);
      if (gap.distance < 0.01) continue;
      bodies.gradient(pair, 0, gap, gradient);
      for (std::size_t j = 0; j < q.size(); ++j) {
        constexpr double kStep = 1e-5;
        moved = q;
        moved[j] += kStep;
        bodies.try_joints(0, moved);
        const double up = bodies.gap_of(pair, 1e9, 0).distance;
        moved[j] -= 2 * kStep;
        bodies.try_joints(0, moved);
        const double down = bodies.gap_of(pair, 1e9, 0).distance;
        ++compared;
        differ += std::abs((up - down) / (2 * kStep) - gradient[j]) > 2e-3;
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_LT(differ, compared / 50) << "nearest points jump where faces and edges are parallel";
}

TEST(GuardBodies, PointsBeforeAPlaneKeepTheirPiecesApart) {
  Random random(8);
  int tried = 0;
  for (int w = 0; w < 12; ++w) {
    RandomCell cell(random);
    GuardBodies bodies({cell.robot}, cell.scene);
    bodies.look(cell.at(collision::random_state(cell.model, random)));
    std::array<GuardGap, 32> points;
    for (std::size_t index = 0; index < bodies.pairs().size(); ++index) {
      const GuardPair& pair = bodies.pairs()[index];
      const GuardGap gap = bodies.gap_of(pair, 1e9);
      if (gap.distance < 1e-3 || gap.distance > 0.2) continue;
      double left_out = 0;
      const std::size_t count = bodies.measure_points(index, 0, gap.distance + 0.05, points, left_out);
      EXPECT_NEAR(pair.slack, gap.distance, 1e-5);
      ASSERT_GT(count, 0u);
      double least = 1e9;
      for (std::size_t i = 0; i < count; ++i) least = std::min(least, points[i].distance);
      EXPECT_NEAR(least, gap.distance, 1e-5);
      ++tried;
    }
  }
  EXPECT_GT(tried, 30);
}

TEST(GuardBodies, AHeldPartBelongsToTheRobotAndALooseOneIsAnObstacleOfLinks) {
  description::RobotModel model = gantry();
  description::Shape bead;
  bead.kind = description::ShapeKind::sphere;
  bead.radius = 0.01;
  model.links[1].collisions = {bead};  // slide_x
  description::Scene scene;
  scene.floor = false;
  scene.fixtures = {fixture("wall", {0.1, 1, 1}, {0.5, 0, 0})};
  description::Part part;
  part.name = "cube";
  part.shape = box(0.04, 0.04, 0.04);
  scene.parts = {part};
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  Moment moment = at(0, 0, 0);
  moment.parts = {{{{0.2, 0, 0}, {}}, true, -1}};
  bodies.look(moment);
  const auto pair_of = [&](const std::string& a, const std::string& b) -> const GuardPair* {
    for (const GuardPair& pair : bodies.pairs())
      if (pair.active && (bodies.name(pair.a) == a || bodies.name(pair.b) == a) &&
          (bodies.name(pair.a) == b || bodies.name(pair.b) == b))
        return &pair;
    return nullptr;
  };
  EXPECT_FALSE(pair_of("arm/ball", "part cube")) << "a hand takes parts";
  ASSERT_TRUE(pair_of("arm/slide_x", "part cube"));
  EXPECT_FALSE(pair_of("fixture wall", "part cube"));
  EXPECT_NEAR(bodies.gap_of(*pair_of("arm/slide_x", "part cube"), 1).distance, 0.2 - 0.02 - 0.01, 1e-6);
  moment.parts[0].held_by = 0;
  bodies.look(moment);
  ASSERT_TRUE(pair_of("fixture wall", "part cube"));
  EXPECT_FALSE(pair_of("arm/ball", "part cube"));
  moment.robots[0].joints = {0.1, 0, 0};
  bodies.look(moment);
  EXPECT_NEAR(bodies.gap_of(*pair_of("fixture wall", "part cube"), 1).distance, 0.45 - 0.3 - 0.02, 1e-6);
}

TEST(GuardBodies, AZoneIsOfTheBodiesOfItsRobot) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene,
                     {{"roof", 0, false, {0, 0, 0.5}, {0, 0, -1}, {}, {}},
                      {"desk", 0, true, {}, {}, {-1, -1, -1}, {1, 1, -0.4}},
                      {"other", 7, false, {0, 0, 0}, {0, 0, 1}, {}, {}}});
  bodies.look(at(0, 0, 0));
  double roof = 1e9, desk = 1e9;
  for (const GuardPair& pair : bodies.pairs()) {
    EXPECT_NE(bodies.name(pair.b), "zone other");
    if (bodies.name(pair.b) == "zone roof") roof = std::min(roof, bodies.gap_of(pair, 1e9).distance);
    if (bodies.name(pair.b) == "zone desk") desk = std::min(desk, bodies.gap_of(pair, 1e9).distance);
  }
  EXPECT_NEAR(roof, 0.5 - kBall, 1e-9);
  EXPECT_NEAR(desk, 0.4 - kBall, 1e-6);
}

TEST(GuardBodies, MoreRobotsThanATickCanFollowAreRefused) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  EXPECT_NO_THROW(GuardBodies(std::vector<Robot>(20, {"arm", &model, nullptr, -1, false, {}}), scene));
  EXPECT_THROW(GuardBodies(std::vector<Robot>(500, {"arm", &model, nullptr, -1, false, {}}), scene), Error);
}

}  // namespace
}  // namespace polyarm::surroundings
