/// Moves of a robot whose own controller interpolates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller_rig.hpp"
#include "polyarm/moves/forward_plan.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "tests/moves/arm_moves.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::moves::forward_motion_test {
namespace {

using controllers::ControllerRig;
using controllers::JointTrajectoryController;
using hardware::ForwardMove;
using test::Arm;
using test::bent;
using test::joint;
using test::line;
using test::shifted;
using test::Values;

/// A controller that turns all joints straight to the end of each move, at a constant speed.
class Robot : public hardware::ForwardMoves {
 public:
  explicit Robot(Values at) : q(std::move(at)) {}
  bool accept(const ForwardMove& move) noexcept override {
    if (full || count == moves.size()) return false;
    moves[count++] = move;
    return true;
  }
  void set_pace(double share) noexcept override { pace = share; }
  void clear() noexcept override {
    ++clears;
    begun = count = 0;
  }
  hardware::ForwardFlow flow() const noexcept override { return {done, begun == count, moves_now == 0}; }
  void step(double dt) {
    moves_now = 0;
    if (begun == count || pace == 0) return;
    const ForwardMove& move = moves[begun];
    double most = 0;
    for (std::size_t j = 0; j < q.size(); ++j) most = std::max(most, std::abs(move.joints[j] - q[j]));
    const double share = std::min(1.0, pace * 0.5 * dt / std::max(most, 1e-12));
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += share * (move.joints[j] - q[j]);
    moves_now = 1;
    if (share < 1) return;
    done = move.id;
    got.push_back(move);
    if (++begun == count) begun = count = 0;
  }
  Values q;
  std::array<ForwardMove, 64> moves;
  std::size_t begun = 0, count = 0;
  std::vector<ForwardMove> got;
  std::uint64_t done = 0;
  double pace = 1;
  int clears = 0, moves_now = 0;
  bool full = false;
};

struct Rig {
  Arm arm{"universal_robots/ur5e"};
  Values from = bent(arm);
  Robot robot{from};
  ControllerRig controller;
  std::unique_ptr<RobotMotion> motion;

  Rig()
      : controller(std::make_unique<JointTrajectoryController>(), arm.chain().names(),
                   {{"joints", arm.chain().names()},
                    {"command_interfaces", {"position"}},
                    {"state_interfaces", {"position"}}}) {
    EXPECT_EQ(controller.configure(), controllers::CallbackReturn::success);
    auto& follower = dynamic_cast<JointTrajectoryController&>(controller.controller());
    follower.set_forward(&robot);
    measure();
    EXPECT_EQ(controller.activate(), controllers::CallbackReturn::success);
    motion = std::make_unique<RobotMotion>(*arm.facts, follower, [](std::function<void()> job) { job(); });
    motion->set_planned(from);
    motion->set_forward([this] { return robot.q; });
  }
  std::string name(std::size_t j) const { return arm.chain().names()[j] + "/position"; }
  void measure() {
    for (std::size_t j = 0; j < from.size(); ++j) controller.state(name(j)) = robot.q[j];
  }
  void pass(int cycles = 1) {
    for (int i = 0; i < cycles; ++i) {
      motion->tick(controller.time());
      robot.step(1e-3);
      measure();
      controller.update();
      for (std::size_t j = 0; j < from.size(); ++j) EXPECT_EQ(controller.command(name(j)), robot.q[j]);
    }
    motion->tick(controller.time());
  }
  template <typename Until>
  void pass_until(Until until, int most = 20000) {
    for (int i = 0; i < most && !until(); ++i) pass();
    EXPECT_TRUE(until());
  }
  void until_idle() {
    pass_until([&] { return motion->idle(); });
  }
  Pose start() const { return arm.chain().forward(from); }
};

TEST(ForwardMotion, MovesGoOutAsMovesAndArriveInOrder) {
  Rig rig;
  const Pose up = shifted(rig.start(), {0, 0, 0.1}), aside = shifted(up, {0, 0.1, 0});
  const auto first = rig.motion->queue(line(up, "up", 0.02));
  const auto second = rig.motion->queue(line(aside, "aside"));
  const auto third = rig.motion->queue(joint(rig.from, "back"));
  rig.pass_until([&] { return rig.motion->move_under_way() == second; });
  EXPECT_EQ(rig.motion->state_of(first), MoveState::running) << "the moves of one motion are done together";
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(third), MoveState::done);
  ASSERT_EQ(rig.robot.got.size(), 3u);
  EXPECT_EQ(rig.robot.got[0].kind, ForwardMove::Kind::line);
  EXPECT_EQ(rig.robot.got[2].kind, ForwardMove::Kind::joint);
  EXPECT_LE(norm(rig.robot.got[0].at.position - up.position), 1e-6)
      << "the corner, which the path does not pass";
  EXPECT_LE(norm(rig.robot.got[1].at.position - aside.position), 1e-6);
  EXPECT_FALSE(rig.robot.got[0].stops);
  EXPECT_DOUBLE_EQ(rig.robot.got[0].blend, 0.02);
  EXPECT_TRUE(rig.robot.got[1].stops);
}

TEST(ForwardMotion, SpeedsAreThoseOfThePlan) {
  Rig rig;
  MovePlanOptions slow;
  slow.joint_share = 0.1;
  rig.motion->set_options(slow);
  Values there = rig.from;
  there[0] += 1;
  rig.motion->queue(joint(there, "there"));
  rig.motion->queue(line(shifted(rig.arm.chain().forward(there), {0, 0, 0.2}), "up"));
  rig.until_idle();
  ASSERT_EQ(rig.robot.got.size(), 2u);
  EXPECT_NEAR(rig.robot.got[0].share, 0.1, 0.005);
  EXPECT_LE(rig.robot.got[1].share, 0.1 + 1e-6);
  EXPECT_GT(rig.robot.got[1].speed, 0.01);
  EXPECT_LE(rig.robot.got[1].speed, 1.0);
}

TEST(ForwardMotion, AJointMoveIsSoSlowThatTheTcpKeepsTheCeilingEverywhere) {
  Rig rig;
  MovePlanOptions reduced;
  reduced.tcp_ceiling = 0.25;
  rig.motion->set_options(reduced);
  Values there = rig.from;
  there[0] += 1;
  there[2] -= 1.2;  // the distance of the TCP from joint 1 changes
  rig.motion->queue(joint(there, "there"));
  rig.until_idle();
  ASSERT_EQ(rig.robot.got.size(), 1u);
  double turned = 0, fastest = 0;  // s of the move at the full speed of the joints; m/s of the TCP then
  for (std::size_t j = 0; j < there.size(); ++j)
    turned = std::max(turned, std::abs(there[j] - rig.from[j]) / rig.arm.facts->limits[j].velocity);
  constexpr int kSteps = 400;
  for (int k = 0; k < kSteps; ++k) {
    const auto place = [&](int step) {
      Values q = rig.from;
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += (there[j] - rig.from[j]) * step / kSteps;
      return rig.arm.chain().forward(q).position;
    };
    fastest = std::max(fastest, norm(place(k + 1) - place(k)) * kSteps / turned);
  }
  EXPECT_LE(rig.robot.got[0].share * fastest, 0.25 * 1.01);
  EXPECT_GT(rig.robot.got[0].share * fastest, 0.2);
}

TEST(ForwardMotion, AnArcHasAPointOfItsOwnPath) {
  Rig rig;
  Move arc;
  arc.kind = MoveKind::arc;
  const Pose from = rig.start();
  arc.targets = {{shifted(from, {0, 0.05, 0.05}), "via"}, {shifted(from, {0, 0.1, 0}), "end"}};
  rig.motion->queue(arc);
  rig.until_idle();
  ASSERT_EQ(rig.robot.got.size(), 1u);
  const Vec3 center = from.position + Vec3{0, 0.05, 0};
  EXPECT_EQ(rig.robot.got[0].kind, ForwardMove::Kind::arc);
  EXPECT_NEAR(norm(rig.robot.got[0].via.position - center), 0.05, 1e-4);
  EXPECT_NEAR(norm(rig.robot.got[0].at.position - center), 0.05, 1e-4);
}

TEST(ForwardMotion, AHoldPausesAndAResumeGoesOn) {
  Rig rig;
  Values there = rig.from;
  there[0] += 0.5;
  const auto move = rig.motion->queue(joint(there, "there"));
  rig.pass(200);
  rig.controller.verdict.speed = 0;
  rig.pass(3);
  EXPECT_EQ(rig.robot.pace, 0);
  EXPECT_TRUE(rig.controller.controller().standing());
  const Values at = rig.robot.q;
  rig.pass(500);
  EXPECT_EQ(rig.robot.q, at);
  EXPECT_EQ(rig.motion->state_of(move), MoveState::running);
  rig.controller.verdict.speed = 0.5;
  rig.pass();
  EXPECT_EQ(rig.robot.pace, 0.5);
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(move), MoveState::done);
  EXPECT_EQ(rig.robot.clears, 0);
}

TEST(ForwardMotion, ADiscardWhileHeldForgetsTheMoves) {
  Rig rig;
  Values there = rig.from;
  there[0] += 0.5;
  const auto move = rig.motion->queue(joint(there, "there"));
  rig.pass(200);
  rig.controller.verdict.speed = 0;
  rig.pass(3);
  rig.controller.verdict.discard = true;
  rig.pass();
  rig.controller.verdict.discard = false;
  rig.controller.verdict.speed = 1;
  const Values at = rig.robot.q;
  rig.pass(100);
  EXPECT_EQ(rig.robot.clears, 1);
  EXPECT_EQ(rig.robot.q, at);
  EXPECT_EQ(rig.motion->state_of(move), MoveState::discarded);
}

TEST(ForwardMotion, AMoveThatIsEndedStopsAndTheNextBeginsWhereTheRobotIs) {
  Rig rig;
  Values there = rig.from;
  there[0] += 0.5;
  const auto move = rig.motion->queue(joint(there, "there"));
  rig.pass(300);
  rig.motion->end(move);
  rig.until_idle();
  EXPECT_EQ(rig.robot.clears, 1);
  EXPECT_EQ(rig.motion->state_of(move), MoveState::done);
  EXPECT_EQ(rig.motion->planned(), rig.robot.q);
  rig.motion->queue(joint(rig.from, "back"));
  rig.until_idle();
  for (std::size_t j = 0; j < rig.from.size(); ++j) EXPECT_NEAR(rig.robot.q[j], rig.from[j], 1e-9);
}

TEST(ForwardMotion, ATrapSetsMovesApartAndSendsWhatWasLeft) {
  Rig rig;
  Values there = rig.from, aside = rig.from;
  there[0] += 0.5;
  aside[1] += 0.2;
  const Pose up = shifted(rig.start(), {0, 0, 0.1});
  const auto first = rig.motion->queue(line(up, "up", 0.02));
  const auto second = rig.motion->queue(joint(there, "there"));
  rig.pass_until([&] { return rig.motion->move_under_way() == second; });
  rig.pass(100);
  rig.motion->suspend();
  rig.pass_until([&] { return rig.motion->suspended(); });
  const Values held = rig.robot.q;
  const auto between = rig.motion->queue(joint(aside, "aside"));
  rig.pass_until([&] { return rig.motion->state_of(between) == MoveState::done; });
  rig.robot.got.clear();
  rig.motion->resume();
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(first), MoveState::done);
  EXPECT_EQ(rig.motion->state_of(second), MoveState::done);
  ASSERT_EQ(rig.robot.got.size(), 2u) << "the way back, and the rest of the second move";
  for (std::size_t j = 0; j < held.size(); ++j) {
    EXPECT_NEAR(rig.robot.got[0].joints[j], held[j], 1e-9);
    EXPECT_NEAR(rig.robot.q[j], there[j], 1e-9);
  }
}

TEST(ForwardMotion, WhatTheControllerCannotDoIsRefused) {
  Rig rig;
  Move curve = line(shifted(rig.start(), {0, 0, 0.1}), "up");
  curve.kind = MoveKind::spline;
  EXPECT_THROW(rig.motion->queue(curve), Error);
  Move through = joint(rig.from, "through");
  through.through = true;
  EXPECT_THROW(rig.motion->queue(through), Error);
  EXPECT_THROW(rig.motion->queue(joint(rig.from, "together"), nullptr, std::make_shared<InStep>(2)), Error);
  EXPECT_THROW(rig.controller.controller().receive("joint_trajectory", controllers::TrajectoryMessage{}),
               Error);
  EXPECT_TRUE(rig.motion->idle());
}

TEST(ForwardMotion, AFullControllerGetsTheMovesLater) {
  Rig rig;
  rig.robot.full = true;
  rig.motion->queue(joint(rig.from, "here"));
  Values there = rig.from;
  there[0] += 0.1;
  rig.motion->queue(joint(there, "there"));
  rig.pass(100);
  EXPECT_FALSE(rig.motion->idle());
  rig.robot.full = false;
  rig.until_idle();
  EXPECT_NEAR(rig.robot.q[0], there[0], 1e-9);
}

TEST(ForwardMotion, TheLoopAllocatesNothing) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers replace the same functions";
  Rig rig;
  Values there = rig.from;
  there[0] += 0.5;
  rig.motion->queue(joint(there, "there"));
  rig.pass(10);
  rig.robot.got.reserve(100);
  const polyarm::test::RealtimeGuard guard;
  for (int i = 0; i < 300; ++i) rig.controller.update();
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::moves::forward_motion_test
