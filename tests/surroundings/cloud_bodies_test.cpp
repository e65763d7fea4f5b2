/// Fixtures of hundreds of boxes, as point clouds are: trees answer as loops over all boxes do.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/collision/checker.hpp"
#include "polyarm/surroundings/guard_bodies.hpp"
#include "tests/collision/judge.hpp"

namespace polyarm::surroundings {
namespace {

using description::Shape;

/// Small boxes in a shell around the robot; each tenth one is turned.
std::vector<Shape> a_cloud(kinematics::Random& random, std::size_t count, double turn) {
  std::vector<Shape> out;
  while (out.size() < count) {
    Shape shape;
    const auto even = [&] { return random.between(-1, 1); };
    shape.pose.position = {even(), even(), 0.5 + 0.7 * even()};
    if (const double r = norm(shape.pose.position - Vec3{0, 0, 0.3}); r < 0.45 || r > 1) continue;
    shape.size = {0.03 + 0.02 * even(), 0.03 + 0.02 * even(), 0.03 + 0.02 * even()};
    if (out.size() % 10 == 0) shape.pose.rotation = from_axis_angle({0, 0, 1}, turn * even());
    out.push_back(shape);
  }
  return out;
}

struct Cell {
  explicit Cell(kinematics::Random& random, std::size_t count, double turn)
      : model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e")) {
    cloud = a_cloud(random, count, turn);
    whole.floor = apart.floor = false;
    whole.fixtures.push_back(
        {"cloud", cloud, {{0.02, 0.01, 0}, from_axis_angle({0, 0, 1}, 0.3 * turn)}, {}, 0.8, {}});
    for (const Shape& shape : cloud)
      apart.fixtures.push_back({"box", {shape}, whole.fixtures[0].pose, {}, 0.8, {}});
    robot.name = "arm";
    robot.model = &model;
    robot.body = robot_body(robot);
  }
  Moment at(const std::vector<double>& q) const {
    Moment out;
    out.robots = {{{}, q}};
    return out;
  }
  description::RobotModel model;
  std::vector<Shape> cloud;
  description::Scene whole, apart;
  Robot robot;
};

TEST(CloudBodies, GuardsMeasureWhatALoopMeasures) {
  kinematics::Random random(5);
  Cell cell(random, 300, 1);
  GuardBodies whole({cell.robot}, cell.whole), apart({cell.robot}, cell.apart);
  int near = 0;
  for (int i = 0; i < 60; ++i) {
    const std::vector<double> q = collision::random_state(cell.model, random);
    whole.look(cell.at(q)), apart.look(cell.at(q));
    std::vector<double> least(whole.bodies(), 1e9);
    for (const GuardPair& pair : apart.pairs())
      if (!pair.own) least[pair.a] = std::min(least[pair.a], apart.gap_of(pair, 1e9).distance);
    for (std::size_t p = 0; p < whole.pairs().size(); ++p) {
      const GuardPair& pair = whole.pairs()[p];
      if (pair.own) continue;
      const double measured = whole.gap_of(pair, 1e9).distance;
      ASSERT_NEAR(measured, least[pair.a], 1e-6);
      near += measured < 0.05;
      if (measured < 1e-3) continue;
      std::array<GuardGap, 8> points;
      double left_out = 0;
      const std::size_t count = whole.measure_points(p, 0, measured + 0.06, points, left_out);
      ASSERT_GT(count, 0u);
      double first = 1e9;
      for (std::size_t k = 0; k < count; ++k) first = std::min(first, points[k].distance);
      ASSERT_NEAR(first, measured, 1e-5);
      ASSERT_GE(left_out, measured - 1e-6) << "what is in no point is not nearer than the nearest";
    }
  }
  EXPECT_GT(near, 20);
}

TEST(CloudBodies, TheCheckerMissesNoContact) {
  kinematics::Random random(6);
  for (const double turn : {0.0, 1.0}) {
    Cell cell(random, 900, turn);
    const Surroundings around({cell.robot}, cell.whole, cell.at(std::vector<double>(6, 0.0)), 0, 0);
    GuardBodies exact({cell.robot}, cell.whole);
    collision::Probe probe(around.checker());
    int touching = 0, alarms = 0, free = 0;
    for (int i = 0; i < 1500; ++i) {
      const std::vector<double> q = collision::random_state(cell.model, random);
      exact.look(cell.at(q));
      double least = 1e9;
      for (const GuardPair& pair : exact.pairs())
        if (!pair.own) least = std::min(least, exact.gap_of(pair, 1e9).distance);
      const bool rough = probe.touches(q), exactly = probe.touches_exactly(q);
      if (least < -1e-6) {
        ++touching;
        ASSERT_TRUE(rough) << least;
        ASSERT_TRUE(exactly) << least;
      } else {
        ++free;
        alarms += rough;
      }
      if (i % 20 == 0 && least < 0.2) {
        const collision::Contact contact = probe.nearest(q);
        if (contact.second == "fixture cloud" && contact.distance > 0)
          ASSERT_NEAR(contact.distance, least, 1e-6);
      }
    }
    EXPECT_GT(touching, 50);
    EXPECT_GT(free, 50);
    std::printf("%d states touch, %d of %d free ones are false alarms of spheres or of the robot itself\n",
                touching, alarms, free);
  }
}

}  // namespace
}  // namespace polyarm::surroundings
