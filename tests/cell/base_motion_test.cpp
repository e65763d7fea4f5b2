/// Moves of a base in programs, by its odometry, in lock-step on the mock.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "polyarm/cell/check.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/jetbot_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

class BaseMotionTest : public ::testing::Test {
 protected:
  CellFile file(const std::string& program) {
    test::write_jetbot_cell(folder, program);
    return read_cell_file(folder.path());
  }
  void start(const std::string& program) { cell = std::make_unique<LockStepCell>(file(program)); }
  struct Place {
    double x = 0, y = 0, heading = 0, speed = 0, turning = 0;
  };
  Place place() {
    controllers::Controller* base = cell->cell().loop().controllers().find("base");
    for (const auto& output : base->outputs()) {
      if (output->name() != "odom") continue;
      output->fetch();
      const std::vector<double>& v = output->value().values;
      return {v[0], v[1], 2 * std::atan2(v[5], v[6]), v[7], v[12]};
    }
    ADD_FAILURE() << "no odometry";
    return {};
  }
  bool ended() { return cell->cell().program()->ended(); }
  double now() { return seconds(cell->cell().loop().cycle().time); }
  void finish(double most = 60) {
    while (!ended() && now() < most) cell->tick();
    ASSERT_TRUE(ended());
    ASSERT_FALSE(cell->cell().program()->failed())
        << cell->cell().program()->status().problem.value_or(Problem{}).text();
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(BaseMotionTest, ASquareEndsWhereItBegan) {
  start("for i in 1 .. 4\n  drive 400mm\n  turn 90deg\nend\n");
  double far = 0, high = 0;
  while (!ended() && now() < 60) {
    cell->tick();
    far = std::max(far, place().x);
    high = std::max(high, place().y);
  }
  const Place at = place();
  EXPECT_FALSE(cell->cell().program()->failed());
  EXPECT_NEAR(at.x, 0, 0.006);
  EXPECT_NEAR(at.y, 0, 0.006);
  EXPECT_NEAR(std::remainder(at.heading, 2 * std::numbers::pi), 0, 0.015);
  EXPECT_NEAR(far, 0.4, 0.01);
  EXPECT_NEAR(high, 0.4, 0.01);
  EXPECT_LT(now(), 16) << "about as soon as its limits allow";
}

TEST_F(BaseMotionTest, SpeedAndAccelerationAreKept) {
  start("drive -300mm, speed 0.1m/s, accel 0.2m/s2\nturn -180deg, speed 50%\n");
  double fastest = 0, quickest = 0, turning = 0, before = 0, time = now();
  while (!ended() && now() < 60) {
    cell->run(0.01);
    const Place at = place();
    fastest = std::max(fastest, std::abs(at.speed));
    turning = std::max(turning, std::abs(at.turning));
    if (now() > time) quickest = std::max(quickest, std::abs(at.speed - before) / (now() - time));
    before = at.speed, time = now();
  }
  EXPECT_NEAR(place().x, -0.3, 0.003);
  EXPECT_NEAR(std::abs(place().heading), std::numbers::pi, 0.01);
  EXPECT_LE(fastest, 0.1 * (1 + 1e-6));
  EXPECT_GT(fastest, 0.09);
  EXPECT_LE(turning, 1.0 * (1 + 1e-6));
  EXPECT_GT(turning, 0.9);
  EXPECT_LE(quickest, 0.5 * (1 + 1e-6));
}

TEST_F(BaseMotionTest, HeldItStandsAndGoesTheRestAfterwards) {
  start("drive 600mm\n");
  cell->run(1.2);
  const double before = place().x;
  EXPECT_GT(before, 0.05);
  cell->result({{"request", "control.hold"}});
  cell->run(1.5);
  const double held = place().x;
  cell->run(1);
  EXPECT_EQ(place().x, held);
  EXPECT_LT(held, 0.55);
  EXPECT_LT(held - before, 0.2);
  cell->result({{"request", "control.resume"}});
  finish();
  EXPECT_NEAR(place().x, 0.6, 0.003);
}

TEST_F(BaseMotionTest, AtAThirdOfTheSpeedItTakesThreeTimesAsLong) {
  start("drive 500mm\n");
  finish();
  const double whole = now();
  start("drive 500mm\n");
  cell->result({{"request", "control.override"}, {"percent", 33}});
  double fastest = 0;
  while (!ended() && now() < 60) {
    cell->tick();
    fastest = std::max(fastest, std::abs(place().speed));
  }
  EXPECT_NEAR(place().x, 0.5, 0.003);
  EXPECT_GT(now(), 2.5 * whole);
  EXPECT_LE(fastest, 0.33 * 0.3 * 1.02);
}

TEST_F(BaseMotionTest, DiscardedItsProgramEnds) {
  start("drive 600mm\nlog \"there\"\n");
  cell->run(1);
  cell->result({{"request", "control.hold"}});
  cell->run(1.5);
  const double held = place().x;
  cell->result({{"request", "control.discard"}});
  cell->run(0.1);
  cell->result({{"request", "control.resume"}});
  cell->run(1);
  EXPECT_TRUE(ended());
  EXPECT_EQ(place().x, held);
}

TEST_F(BaseMotionTest, ABaseWhoseControllerIsNotActiveFailsItsLineInsteadOfWaitingForEver) {
  start("wait 100ms\ndrive 600mm\nlog \"there\"\n");
  cell->run(0.05);
  cell->result({{"request", "control.switch"}, {"deactivate", Json::array({"base"})}});
  while (!ended() && now() < 60) cell->tick();
  ASSERT_TRUE(cell->cell().program()->failed());
  const Problem why = *cell->cell().program()->status().problem;
  EXPECT_EQ(why.code, "base-silent");
  EXPECT_EQ(why.where.line, 2);
  EXPECT_LT(now(), 10);
}

TEST_F(BaseMotionTest, WhatDoesNotFitIsRefusedWithItsLine) {
  const auto told = [&](const std::string& program) {
    try {
      LockStepCell refused(file(program));
      return std::string("none");
    } catch (const Error& e) {
      std::string all;
      for (const Problem& problem : e.problems()) all += problem.text() + "\n";
      return all;
    }
  };
  EXPECT_NE(told("drive 90deg\n").find("go.script:1:7: error: 'drive' takes a length"), std::string::npos)
      << told("drive 90deg\n");
  EXPECT_NE(told("turn 1m\n").find("takes an angle"), std::string::npos);
  EXPECT_NE(told("drive 90deg\n").find("or a pose"), std::string::npos);
  EXPECT_NE(told("drive 1m, blend 5mm\n").find("belongs to a move of an arm"), std::string::npos);
  EXPECT_NE(told("drive\n").find("drive 500mm"), std::string::npos);
  start("drive 0.1m, speed 30deg/s\n");
  cell->run(0.5);
  ASSERT_TRUE(cell->cell().program()->failed());
  EXPECT_EQ(cell->cell().program()->status().problem->where.line, 1);
}

}  // namespace
}  // namespace polyarm::cell
