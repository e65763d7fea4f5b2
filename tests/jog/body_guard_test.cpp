/// Arms that are jogged at random among obstacles: none ever touches one, and each can always leave.
#include "polyarm/jog/body_guard.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>

#include "tests/jog/among.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::jog {
namespace {

using test::joint_setpoint;
using test::tcp_setpoint;

JogSetpoint random_setpoint(Among& among, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> even(-1, 1);
  const JogRig& rig = among.rig;
  JogSetpoint wish;
  switch (engine() % 5) {
    case 0:
      return joint_setpoint(engine() % rig.chain.joints(), 2 * even(engine));
    case 1:
      wish.kind = JogSetpoint::Kind::joint_velocity;
      for (std::size_t j = 0; j < rig.chain.joints(); ++j) wish.joints[j] = 1.5 * even(engine);
      return wish;
    case 2:
      return tcp_setpoint({0.5 * even(engine), 0.5 * even(engine), 0.5 * even(engine)});
    case 3:
      return tcp_setpoint({0.3 * even(engine), 0.3 * even(engine), 0.3 * even(engine), even(engine), even(engine),
                       even(engine)},
                      true);
    default:
      wish.kind = engine() % 2 ? JogSetpoint::Kind::joint_target : JogSetpoint::Kind::tcp_target;
      for (std::size_t j = 0; j < rig.chain.joints(); ++j) wish.joints[j] = rig.joints()[j] + even(engine);
      wish.target = rig.tcp();
      wish.target.position =
          wish.target.position + Vec3{0.3 * even(engine), 0.3 * even(engine), 0.3 * even(engine)};
      return wish;
  }
}

/// POLYARM_JOGS: how many jogs for each arm.
long jogs() {
  const char* const given = std::getenv("POLYARM_JOGS");
  return given ? std::atol(given) : 200;
}

class RandomJogs : public testing::TestWithParam<std::string> {};

TEST_P(RandomJogs, AmongObstaclesKeepTheirMargin) {
  const std::string arm = GetParam();
  std::mt19937_64 engine(21);
  std::uniform_real_distribution<double> even(0, 1);
  double nearest = 1e9, excess = 1e9, moved = 0;
  std::string worst;
  long held = 0, cycles = 0;
  std::uint64_t measured = 0;
  for (long i = 0; i < jogs();) {
    Among among(arm, engine(), 12);
    if (!among.start()) continue;
    for (int k = 0; k < 25 && i < jogs(); ++k, ++i) {
      const Vec3 before = among.rig.tcp().position;
      ASSERT_TRUE(among.run(random_setpoint(among, engine), 0.05 + 0.4 * even(engine)))
          << arm << " " << among.rig.broken;
      moved += norm(among.rig.tcp().position - before);
    }
    ASSERT_GT(among.excess, -kSlip) << arm << " jog " << i << ": " << among.worst;
    nearest = std::min(nearest, among.nearest);
    if (among.excess < excess) excess = among.excess, worst = among.worst;
    held += among.held, cycles += static_cast<long>(among.rig.cycles);
    measured += among.bodies->measured();
  }
  EXPECT_GT(held, 10) << arm;
  EXPECT_GT(moved, 0.01 * static_cast<double>(jogs())) << arm;
  std::printf(
      "%-24s %ld jogs, %ld cycles, %.1f m, nearest %.2f mm, %.3f mm more than kept (%s), held back in %ld "
      "cycles, %.1f distances a tick\n",
      arm.c_str(), jogs(), cycles, moved, 1e3 * nearest, 1e3 * excess, worst.c_str(), held,
      2.0 * static_cast<double>(measured) / static_cast<double>(cycles));
}

INSTANTIATE_TEST_SUITE_P(OfArms, RandomJogs,
                         testing::Values("universal_robots/ur5e", "fanuc/lr_mate_200id",
                                         "universal_robots/ur3", "franka/fer_panda",
                                         "mitsubishi_electric/rh_6frh5520", "gantry"),
                         [](const auto& info) { return info.param.substr(info.param.find('/') + 1); });

/// An arm beside a wall and a ball of hundreds of boxes, as a point cloud is.
TEST(BodyGuard, AnArmIsKeptOffAPointCloud) {
  std::mt19937_64 engine(4);
  std::uniform_real_distribution<double> even(-1, 1);
  long held = 0;
  for (int k = 0; k < 3; ++k) {
    Among arm("universal_robots/ur5e", engine(), 0);
    description::Fixture cloud;
    cloud.name = "cloud";
    for (int i = 0; i < 500; ++i) {
      description::Shape box;
      const Vec3 way{even(engine), even(engine), even(engine)};
      box.pose.position =
          i % 2 ? Vec3{0.5, 1.5 * way.x, 0.5 + way.y} : Vec3{-0.5, 0, 0.6} + (0.15 / norm(way)) * way;
      box.size = {0.02, 0.08, 0.08};
      cloud.shapes.push_back(box);
    }
    arm.scene.fixtures = {cloud};
    arm.renew();
    if (!arm.start()) continue;
    for (int i = 0; i < 25; ++i) {
      ASSERT_TRUE(arm.run(random_setpoint(arm, engine), 0.3)) << arm.rig.broken;
      ASSERT_GT(arm.excess, -kSlip) << arm.worst << " " << i;
    }
    held += arm.held;
  }
  EXPECT_GT(held, 100);
}

/// A UR5e above a table.
struct AboveATable : Among {
  AboveATable() : Among("universal_robots/ur5e", 1, 0) {
    description::Fixture table;
    table.name = "table";
    description::Shape top;
    top.size = {3, 3, 0.1};
    table.shapes = {top};
    table.pose.position = {0, 0, -0.05};
    scene.fixtures = {table};
    renew();
    rig.start({0.3, -1.2, 1.6, -1.9, -1.4, 0.5});
    before = rig.joints();
  }
};

TEST(BodyGuard, TheTcpComesDownToTheClearanceAndStops) {
  AboveATable arm;
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.2}), 4)) << arm.rig.broken;
  EXPECT_EQ(arm.rig.generator.hold(), JogHold::body);
  EXPECT_LT(arm.rig.generator.tcp_speed(), 1e-3);
  EXPECT_NEAR(arm.distance(), kClearance, 0.0015);
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, 0.2}), 0.5));
  EXPECT_GT(arm.distance(), 0.03) << "it goes away freely";
}

TEST(BodyGuard, TheTcpSlidesAlong) {
  AboveATable arm;
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.2}), 4));
  const Vec3 before = arm.rig.tcp().position;
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0.1, -0.1}), 1)) << arm.rig.broken;
  EXPECT_GT(arm.rig.tcp().position.y - before.y, 0.05);
  EXPECT_GT(arm.distance(), kClearance - 0.001);
  EXPECT_EQ(arm.rig.generator.hold(), JogHold::body);
}

TEST(BodyGuard, OneJointAloneDoesNotMoveOthers) {
  AboveATable arm;
  const std::vector<double> before = arm.rig.joints();
  ASSERT_TRUE(arm.run(joint_setpoint(1, 0.5), 5)) << arm.rig.broken;
  for (std::size_t j = 0; j < before.size(); ++j) EXPECT_EQ(arm.rig.joints()[j] == before[j], j != 1) << j;
  EXPECT_GT(arm.distance(), kClearance - 0.001);
}

TEST(BodyGuard, AnArmThatIsTooNearMayOnlyLeave) {
  AboveATable arm;
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.2}), 4));
  arm.scene.fixtures[0].pose.position.z += 0.008;  // it comes up: 3 mm inside
  arm.renew();
  arm.rig.start(arm.rig.joints());
  const double start = arm.distance();
  ASSERT_LT(start, 0);
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.1}), 0.5)) << arm.rig.broken;
  EXPECT_GT(arm.distance(), start - 0.0005);
  EXPECT_TRUE(arm.barriers.touching);
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, 0.1}), 1)) << arm.rig.broken;
  EXPECT_GT(arm.distance(), kClearance);
}

/// Not each of its corners that touch has a barrier.
TEST(BodyGuard, AToolOfManyCornersThatIsTooNearMayLeave) {
  description::Tool tool;
  description::Shape disc;
  disc.kind = description::ShapeKind::mesh;
  std::vector<Vec3> corners;
  for (int i = 0; i < 16; ++i)
    for (const double z : {0.0, 0.04})
      corners.push_back({0.06 * std::cos(i * M_PI / 8), 0.06 * std::sin(i * M_PI / 8), z});
  disc.pieces = {corners};
  tool.body = {disc};
  AboveATable arm;
  arm.robot.tool = &tool;
  arm.robot.body = nullptr;
  arm.robot.body = surroundings::robot_body(arm.robot);
  arm.renew();
  arm.rig.start({0.3, -1.2, 1.6, -1.9708, -1.5708, 0.5});  // the tool looks down
  arm.before = arm.rig.joints();
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.2}), 3)) << arm.rig.broken;
  arm.scene.fixtures[0].pose.position.z += 0.003;  // it comes up
  arm.renew();
  arm.rig.start(arm.rig.joints());
  ASSERT_LT(arm.distance(), 0);
  ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, 0.1}), 8)) << arm.rig.broken;
  EXPECT_GT(arm.distance(), 0.005);
}

/// A flat tool is parallel to a table: whichever way it tilts, its rim comes first.
TEST(BodyGuard, AFlatToolTiltsNowhereIntoATable) {
  description::Tool tool;
  description::Shape disc;
  disc.kind = description::ShapeKind::cylinder;
  disc.radius = 0.06, disc.length = 0.04, disc.pose.position.z = 0.02;
  tool.body = {disc};
  for (int k = 0; k < 4; ++k) {
    AboveATable arm;
    arm.robot.tool = &tool;
    arm.robot.body = nullptr;
    arm.robot.body = surroundings::robot_body(arm.robot);
    arm.renew();
    arm.rig.start({0.3, -1.2, 1.6, -1.9708, -1.5708, 0.5});  // the tool looks down
    arm.before = arm.rig.joints();
    arm.excess = 1e9;
    ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, -0.2}), 3)) << arm.rig.broken;
    EXPECT_LT(arm.distance(), 0.004) << "it comes near";
    const double angle = 0.3 + k * 1.57;
    ASSERT_TRUE(arm.run(tcp_setpoint({0, 0, 0, 2 * std::cos(angle), 2 * std::sin(angle), 0}), 0.5));
    EXPECT_GT(arm.excess, -kSlip) << arm.worst << " " << k;
  }
}

/// Away from one is towards the other.
TEST(BodyGuard, ABallThatIsTooNearToTwoWallsCanGoAlongThem) {
  Among arm("gantry", 1, 0);
  for (const double side : {-1.0, 1.0})
    arm.scene.fixtures.push_back(surroundings::fixture(side < 0 ? "below" : "above", {1, 0.2, 0.1},
                                                       {0, 0, side * (surroundings::kBall + 0.0504)}));
  arm.renew();
  arm.rig.start({0, 0, 0});
  arm.before = arm.rig.joints();
  ASSERT_TRUE(arm.run(joint_setpoint(1, 0.1), 8)) << arm.rig.broken;
  EXPECT_GT(arm.rig.joints()[1], 0.01);
  EXPECT_GT(arm.excess, -0.0006 - 1e-4) << arm.worst;
}

/// As far as Barriers::room() says, nothing comes nearer than it may: what has barriers and what has none.
TEST(BodyGuard, WhatHasRoomInTheBarriersKeepsItsDistance) {
  std::uniform_real_distribution<double> even(-1, 1);
  std::mt19937_64 engine(17);
  long bounded = 0, of_barriers = 0, of_rest = 0;
  for (const std::string arm : {"universal_robots/ur5e", "fanuc/lr_mate_200id"})
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      Among among(arm, seed, seed % 2 ? 40 : 8);
      if (!among.start()) continue;
      // Few exact distances: more is left to what has no barrier.
      BodyGuard guard(*among.bodies, 0, test::axis_limits(among.rig.model),
                      BodyGuardOptions{kClearance, 0.001, seed % 3 ? 400u : 20u});
      const std::vector<double> q = among.rig.joints();
      std::vector<double> v(q.size(), 0.0);
      for (double& rate : v) rate = even(engine);
      Barriers& barriers = among.barriers;
      for (int tick = 0; tick < 2; ++tick) {  // the first one measures what is unknown
        among.bodies->look(Among::at(q));
        guard.fill(v, among.nobody, barriers);
      }
      for (int k = 0; k < 40; ++k) {
        std::vector<double> way(q.size());
        double farthest = 0;
        for (std::size_t j = 0; j < way.size(); ++j) {
          way[j] = std::pow(even(engine), 3);
          farthest += barriers.lever[j] * std::abs(way[j]);
        }
        for (double& by : way) by *= 0.06 / farthest;  // m: some ticks
        const auto least = [&](double share, std::vector<double>& to) {
          for (std::size_t j = 0; j < q.size(); ++j) to[j] = q[j] + share * way[j];
          double out = 1e9;
          for (std::size_t i = 0; i <= barriers.count; ++i) out = std::min(out, barriers.room(i, to));
          return out;
        };
        std::vector<double> to(q.size());
        double low = 0, high = 1;
        if (least(0, to) < 0) continue;
        for (int i = 0; i < 30; ++i) (least((low + high) / 2, to) >= 0 ? low : high) = (low + high) / 2;
        bounded += high < 1;
        ASSERT_GE(least(low, to), 0);
        (barriers.room(barriers.count, to) < 1e-6 ? of_rest : of_barriers) += 1;
        among.exact->look(Among::at(to));
        for (const GuardPair& pair : among.exact->pairs()) {
          if (!pair.active) continue;
          ASSERT_GE(among.exact->gap_of(pair, 0.1).distance, among.kept(pair) - 1e-3)
              << arm << " " << seed << " " << k << ": " << among.exact->name(pair.a) << ", "
              << among.exact->name(pair.b);
        }
      }
    }
  std::printf("%ld ways were bounded: %ld by barriers, %ld by what has none\n", bounded, of_barriers,
              of_rest);
  EXPECT_GT(bounded, 10);
  EXPECT_GT(of_rest, 0);
}

TEST(BodyGuard, ATickAndACycleAllocateNothing) {
  Among among("universal_robots/ur5e", 3, 50);
  ASSERT_TRUE(among.start());
  const std::vector<double> still(6, 0.0);
  const JogSetpoint wish = tcp_setpoint({0.1, 0.1, -0.1});
  Moment moment = Among::at(among.rig.joints());
  among.bodies->look(moment);
  std::string violations;
  {
    test::RealtimeGuard guard;
    for (int i = 0; i < 1000; ++i) {
      for (std::size_t j = 0; j < 6; ++j) moment.robots[0].joints[j] = among.rig.generator.axis(j).position;
      among.bodies->look(moment);
      among.guard->fill(still, among.nobody, among.barriers);
      among.rig.generator.set_barriers(&among.barriers);
      among.rig.generator.step(wish, among.rig.limits);
      among.rig.generator.step(wish, among.rig.limits);
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm::jog
