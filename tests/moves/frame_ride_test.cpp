#include "polyarm/moves/frame_ride.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "polyarm/controllers/controller_rig.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "tests/moves/arm_moves.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::moves::frame_ride_test {
namespace {

using controllers::ControllerRig;
using controllers::JointTrajectoryController;
using test::Arm;
using test::bent;
using test::line;
using test::shifted;
using test::Values;

/// An arm beside a belt whose travel a test states.
struct Rig {
  Arm arm{"universal_robots/ur5e"};
  Values from = bent(arm);
  ControllerRig controller;
  std::unique_ptr<RobotMotion> motion;
  MovingFrame frame;
  double start_travel = 0, speed = 0, change = 0,
         phase = 0;  ///< m or rad; its speed goes up and down by `change`
  std::vector<Values> trace;
  double worst_velocity = 0, worst_acceleration = 0, worst_jerk = 0;  ///< shares of the limits
  bool fed = true;

  explicit Rig(bool turns = false)
      : controller(std::make_unique<JointTrajectoryController>(), arm.chain().names(),
                   {{"joints", arm.chain().names()},
                    {"command_interfaces", {"position"}},
                    {"state_interfaces", {"position"}}}) {
    for (controllers::JointFacts& facts : controller.context().joints.edit())
      facts.velocity = 3, facts.acceleration = 12, facts.jerk = 120;
    EXPECT_EQ(controller.configure(), controllers::CallbackReturn::success);
    for (std::size_t j = 0; j < from.size(); ++j)
      controller.state(name(j)) = controller.command(name(j)) = from[j];
    EXPECT_EQ(controller.activate(), controllers::CallbackReturn::success);
    motion = std::make_unique<RobotMotion>(*arm.facts,
                                           dynamic_cast<JointTrajectoryController&>(controller.controller()),
                                           [](std::function<void()> job) { job(); });
    motion->set_planned(from);
    frame.turns = turns;
    frame.at_zero.position = shifted(start(), {0.1, 0.4, 0}).position;
    frame.at_zero.rotation = from_rpy(0, 0, 1.2);
  }
  std::string name(std::size_t j) const { return arm.chain().names()[j] + "/position"; }
  Values commanded() {
    Values q;
    for (std::size_t j = 0; j < from.size(); ++j) q.push_back(controller.command(name(j)));
    return q;
  }
  Pose tcp() { return arm.chain().forward(commanded()); }
  Pose start() const { return arm.chain().forward(from); }
  /// Smooth changes of speed: a sine of half a second's wave.
  FrameTravel travel_at(Nanoseconds time) const {
    const double t = seconds(time), w = 4;
    return {start_travel + speed * t + change / w * std::sin(w * t + phase),
            speed + change * std::cos(w * t + phase), -change * w * std::sin(w * t + phase), time};
  }
  FrameTravel now() { return travel_at(controller.time()); }
  void begin_ride() {
    motion->feed_ride(now());
    motion->begin_ride(frame, now().travel);
  }
  void step() {
    if (fed) motion->feed_ride(now());
    motion->tick(controller.time());
    controller.update();
    trace.push_back(commanded());
    if (trace.size() < 4) return;
    const std::size_t k = trace.size() - 1;
    const double dt = 1e-3;
    for (std::size_t j = 0; j < from.size(); ++j) {
      const auto q = [&](std::size_t back) { return trace[k - back][j]; };
      worst_velocity = std::max(worst_velocity, std::abs(q(0) - q(1)) / dt / 3);
      worst_acceleration = std::max(worst_acceleration, std::abs(q(0) - 2 * q(1) + q(2)) / dt / dt / 12);
      worst_jerk = std::max(worst_jerk, std::abs(q(0) - 3 * q(1) + 3 * q(2) - q(3)) / dt / dt / dt / 120);
    }
  }
  void expect_limits_kept() const {
    EXPECT_LE(worst_velocity, 1 + 1e-6);
    EXPECT_LE(worst_acceleration, 1 + 1e-3);
    EXPECT_LE(worst_jerk, 1.01);
  }
  /// The TCP in the place of the frame that the last command aims at, as if the frame stood at its begin.
  Pose in_frame() { return inverse(frame.motion(now().travel - began)) * tcp(); }
  double began = 0;
};

TEST(FrameRide, TheToolFollowsABeltWithinAMillimetreAndNoLimitIsExceeded) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> speed(-0.4, 0.4), change(0, 0.1), turn(-3, 3);
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE(round);
    Rig rig;
    rig.frame.at_zero.rotation = from_rpy(0, 0, turn(engine));
    rig.speed = round == 0 ? 0.3 : speed(engine), rig.change = round == 0 ? 0 : change(engine),
    rig.phase = turn(engine);
    for (int i = 0; i < round * 37; ++i) rig.step();
    rig.began = rig.now().travel;
    rig.begin_ride();
    const Pose goal = shifted(rig.start(), {0.02, -0.03, -0.05});
    Move down = line(goal, "the part");
    down.speed = down.acceleration = 0.5;
    rig.motion->queue(down);
    rig.motion->close();
    int cycles = 0;
    while (!rig.motion->at_end() && cycles++ < 3000) rig.step(), rig.motion->at_end();
    ASSERT_LT(cycles, 1500) << "not synchronised";
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      rig.step();
      worst = std::max(worst, norm(rig.in_frame().position - goal.position));
    }
    EXPECT_LT(worst, 0.5e-3);
    rig.motion->end_ride();
    for (int i = 0; i < 2000 && rig.motion->riding(); ++i) rig.step();
    EXPECT_TRUE(rig.motion->idle());
    EXPECT_EQ(rig.motion->planned(), rig.commanded());
    rig.expect_limits_kept();
    const Move back = line(rig.start(), "start");
    rig.motion->queue(back);
    rig.motion->close();
    for (int i = 0; i < 4000 && !rig.motion->idle(); ++i) rig.step();
    EXPECT_LT(norm(rig.tcp().position - rig.start().position), 1e-6);
  }
}

TEST(FrameRide, TheToolTurnsWithATurntable) {
  Rig rig(true);
  rig.speed = 0.4;
  rig.began = rig.now().travel;
  rig.begin_ride();
  for (int i = 0; i < 600; ++i) rig.step();
  EXPECT_LT(norm(rig.in_frame().position - rig.start().position), 1e-4);
  EXPECT_LT(angle_between(rig.in_frame().rotation, rig.start().rotation), 1e-3);
  rig.expect_limits_kept();
}

TEST(FrameRide, AHeldRobotStandsAndCatchesUpAfterwards) {
  Rig rig;
  rig.speed = -0.2;
  rig.began = rig.now().travel;
  rig.begin_ride();
  for (int i = 0; i < 400; ++i) rig.step();
  rig.controller.verdict.speed = 0;
  for (int i = 0; i < 400; ++i) rig.step();
  const Values held = rig.commanded();
  EXPECT_TRUE(rig.controller.controller().standing());
  for (int i = 0; i < 50; ++i) rig.step();
  EXPECT_EQ(rig.commanded(), held);
  rig.controller.verdict.speed = 1;
  for (int i = 0; i < 900; ++i) rig.step();
  EXPECT_LT(norm(rig.in_frame().position - rig.start().position), 1e-4);
  rig.expect_limits_kept();
}

TEST(FrameRide, ARobotThatCannotFollowComesToRest) {
  Rig rig;
  rig.speed = 0.4;
  rig.begin_ride();
  int cycles = 0;
  while (!rig.motion->ride_lost() && ++cycles < 10000) rig.step();
  ASSERT_TRUE(rig.motion->ride_lost());
  rig.motion->fail_ride({"missed", {}, "out of reach", {}});
  for (int i = 0; i < 1000; ++i) rig.step();
  EXPECT_FALSE(rig.motion->riding());
  EXPECT_TRUE(rig.controller.controller().standing());
  rig.expect_limits_kept();
}

TEST(FrameRide, WithoutNewsOfTheFrameTheRideIsLost) {
  Rig rig;
  rig.speed = 0.2;
  rig.begin_ride();
  for (int i = 0; i < 300; ++i) rig.step();
  EXPECT_FALSE(rig.motion->ride_lost());
  rig.fed = false;
  for (int i = 0; i < 150; ++i) rig.step();
  EXPECT_TRUE(rig.motion->ride_lost());
}

TEST(FrameRide, ACycleOfARideAllocatesAndWaitsForNothing) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers replace the same functions";
  Rig rig;
  rig.speed = 0.2;
  rig.begin_ride();
  for (int i = 0; i < 20; ++i) rig.step();
  for (int i = 0; i < 500; ++i) {
    rig.motion->feed_ride(rig.now());
    rig.motion->tick(rig.controller.time());
    const polyarm::test::RealtimeGuard guard;
    rig.controller.update();
    ASSERT_EQ(guard.violations(), "");
  }
}

TEST(FrameRide, TheMovesThatAreLeftFailWithTheRide) {
  Rig rig;
  rig.speed = 0.2;
  rig.begin_ride();
  const auto first = rig.motion->queue(line(shifted(rig.start(), {0, 0, -0.1}), "down"));
  const auto second = rig.motion->queue(line(rig.start(), "up"));
  rig.motion->close();
  for (int i = 0; i < 100; ++i) rig.step();
  rig.motion->fail_ride({"missed", {}, "it has gone", {}});
  for (int i = 0; i < 1000; ++i) rig.step();
  EXPECT_EQ(rig.motion->state_of(first), MoveState::failed);
  EXPECT_EQ(rig.motion->problem_of(first)->what, "it has gone");
  EXPECT_EQ(rig.motion->state_of(second), MoveState::discarded);
  EXPECT_TRUE(rig.motion->idle());
  EXPECT_EQ(rig.motion->planned(), rig.commanded());
  rig.expect_limits_kept();
}

TEST(FrameRide, AMoveThatIsUnderWayAtTheEndOfARideIsGivenUpWithoutAJump) {
  Rig rig;
  rig.speed = 0.2;
  rig.begin_ride();
  for (int i = 0; i < 500; ++i) rig.step();
  rig.motion->end_ride();
  rig.step();
  ASSERT_TRUE(rig.motion->ride_ends());
  Move down = line(shifted(rig.start(), {0, 0, -0.1}), "down");
  down.speed = 0.2;
  const auto late = rig.motion->queue(down);
  rig.motion->close();
  for (int i = 0; i < 2000; ++i) rig.step();
  EXPECT_EQ(rig.motion->state_of(late), MoveState::discarded);
  EXPECT_TRUE(rig.motion->idle());
  EXPECT_EQ(rig.motion->planned(), rig.commanded());
  rig.expect_limits_kept();
}

TEST(FrameRide, ARideThatEndsBeforeItsFirstCycleLeavesTheRobotWhereItIs) {
  Rig rig;
  rig.speed = 0.2;
  rig.begin_ride();
  rig.motion->end_ride();
  rig.motion->tick(rig.controller.time());
  EXPECT_TRUE(rig.motion->idle());
  EXPECT_EQ(rig.motion->planned(), rig.from);
}

}  // namespace
}  // namespace polyarm::moves::frame_ride_test
