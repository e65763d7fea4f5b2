#include "polyarm/moves/robot_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/controllers/controller_rig.hpp"
#include "tests/moves/arm_moves.hpp"

namespace polyarm::moves::robot_motion_test {
namespace {

using controllers::ControllerRig;
using controllers::JointTrajectoryController;
using test::Arm;
using test::bent;
using test::joint;
using test::line;
using test::shifted;
using test::Values;

/// An arm, its controller, and the jobs of planning, which a test may hold back.
struct Rig {
  Arm arm{"universal_robots/ur5e"};
  Values from = bent(arm);
  ControllerRig controller;
  std::vector<std::function<void()>> jobs;
  bool holds_jobs = false;
  std::unique_ptr<RobotMotion> motion;

  Rig()
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
                                           [this](std::function<void()> job) {
                                             if (holds_jobs)
                                               jobs.push_back(std::move(job));
                                             else
                                               job();
                                           });
    motion->set_planned(from);
  }
  std::string name(std::size_t j) const { return arm.chain().names()[j] + "/position"; }
  Values commanded() {
    Values q;
    for (std::size_t j = 0; j < from.size(); ++j) q.push_back(controller.command(name(j)));
    return q;
  }
  Pose tcp() { return arm.chain().forward(commanded()); }
  Pose start() const { return arm.chain().forward(from); }
  void pass(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      if (i % 2 == 0) motion->tick(controller.time());
      controller.update();
    }
    motion->tick(controller.time());
  }
  int until_idle(int most = 20000) {
    for (int i = 0; i < most; ++i) {
      motion->tick(controller.time());
      if (motion->idle()) return i;
      controller.update();
    }
    ADD_FAILURE() << "still moving";
    return most;
  }
};

TEST(RobotMotion, AProgramLooksABoundedNumberOfMovesAhead) {
  Rig rig;
  rig.holds_jobs = true;  // nothing is planned
  const Pose up = shifted(rig.start(), {0, 0, 0.01});
  std::size_t asked = 0;
  for (; asked < 3 * RobotMotion::kMostAhead && rig.motion->has_room(); ++asked) {
    rig.motion->queue(asked % 2 == 0 ? line(up, "up") : joint(rig.from, "back"));
    rig.motion->tick(rig.controller.time());
  }
  EXPECT_EQ(asked, RobotMotion::kMostAhead);
  EXPECT_FALSE(rig.motion->has_room());
  rig.motion->drop();
  rig.until_idle();
  EXPECT_TRUE(rig.motion->has_room());
}

TEST(RobotMotion, AProgramLooksABoundedTimeAhead) {
  Rig rig;
  MovePlanOptions slow = rig.motion->options();
  slow.tcp_ceiling = 0.01;
  slow.joint_share = 0.01;
  rig.motion->set_options(slow);
  const Pose up = shifted(rig.start(), {0, 0, 0.2});
  std::size_t asked = 0;
  const auto ask = [&] {  // as an endless loop of a program does, tick after tick
    for (; asked < RobotMotion::kMostAhead && rig.motion->has_room(); ++asked) {
      rig.motion->queue(asked % 2 == 0 ? line(up, "up") : joint(rig.from, "back"));
      rig.motion->tick(rig.controller.time());
    }
  };
  ask();
  EXPECT_GE(asked, 3u) << "one under way and two that are ready, however long they are";
  EXPECT_LT(asked, RobotMotion::kMostAhead / 10);
  EXPECT_FALSE(rig.motion->has_room());
  const std::size_t before = asked;
  for (int i = 0; i < 100 && !rig.motion->has_room(); ++i) rig.pass(1000);
  ask();
  EXPECT_GT(asked, before) << "the program goes on when a motion has ended";
}

TEST(RobotMotion, CarriesOutItsMovesInOrder) {
  Rig rig;
  const Pose up = shifted(rig.start(), {0, 0, 0.1});
  const auto first = rig.motion->queue(line(up, "up"));
  const auto second = rig.motion->queue(joint(rig.from, "back"));
  rig.pass(50);
  EXPECT_EQ(rig.motion->state_of(first), MoveState::running);
  while (rig.motion->state_of(first) == MoveState::running) rig.pass(2);
  EXPECT_EQ(rig.motion->state_of(first), MoveState::done);
  EXPECT_EQ(rig.motion->state_of(second), MoveState::running);
  EXPECT_LE(norm(rig.tcp().position - up.position), 1e-3);
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(second), MoveState::done);
  for (std::size_t j = 0; j < rig.from.size(); ++j) EXPECT_NEAR(rig.commanded()[j], rig.from[j], 1e-9);
}

TEST(RobotMotion, ABlendWaitsForTheNextMoveOrForTheEnd) {
  Rig rig;
  const Pose up = shifted(rig.start(), {0, 0, 0.1}), over = shifted(rig.start(), {0.1, 0, 0.1});
  rig.motion->queue(line(up, "up", 0.03));
  rig.pass(100);
  EXPECT_EQ(rig.commanded(), rig.from) << "nobody knows yet where it goes on";
  rig.motion->queue(line(over, "over"));
  double nearest = 1;
  while (!rig.motion->idle()) {
    rig.pass(2);
    nearest = std::min(nearest, norm(rig.tcp().position - up.position));
  }
  EXPECT_GT(nearest, 1e-3);
  EXPECT_LT(nearest, 0.03);
  EXPECT_LE(norm(rig.tcp().position - over.position), 1e-9);

  const auto last = rig.motion->queue(line(up, "up", 0.03));
  rig.motion->close();
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(last), MoveState::done);
  EXPECT_LE(norm(rig.tcp().position - up.position), 1e-9);
}

TEST(RobotMotion, AMoveThroughItsEndWaitsForTheNextOneOrForTheEnd) {
  Rig rig;
  Values a = rig.from, b = rig.from;
  a[0] += 0.3;
  b[0] += 0.4, b[1] += 0.2;
  Move through = joint(a, "a");
  through.through = true;
  const auto first = rig.motion->queue(through);
  rig.pass(100);
  EXPECT_EQ(rig.commanded(), rig.from) << "nobody knows yet where it goes on";
  const auto last = rig.motion->queue(joint(b, "b"));
  double nearest = 1;
  while (!rig.motion->idle()) {
    rig.pass(1);
    nearest = std::min(nearest, std::hypot(rig.commanded()[0] - a[0], rig.commanded()[1] - a[1]));
  }
  EXPECT_LT(nearest, 2e-3);
  EXPECT_EQ(rig.motion->state_of(first), MoveState::done);
  EXPECT_EQ(rig.motion->state_of(last), MoveState::done);
  for (std::size_t j = 0; j < b.size(); ++j) EXPECT_NEAR(rig.commanded()[j], b[j], 1e-9);
  rig.motion->queue(through);
  rig.motion->close();
  rig.until_idle();
  EXPECT_NEAR(rig.commanded()[0], a[0], 1e-9);
}

TEST(RobotMotion, ANewTcpIsNotBlendedInto) {
  Rig rig;
  const auto other = with_chain(
      *rig.arm.facts, kinematics::Chain(rig.arm.model, rig.arm.model.tool_link(), {}, {{0, 0, 0.2}, {}}));
  const Pose tip = other->chain.forward(rig.from);
  rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up", 0.03));
  rig.motion->queue(line(shifted(tip, {0, 0.05, 0.1}), "tip"), other);
  rig.until_idle();
  EXPECT_LE(norm(other->chain.forward(rig.commanded()).position - shifted(tip, {0, 0.05, 0.1}).position),
            1e-9);
}

TEST(RobotMotion, WhatCannotBePlannedSaysWhichAndEndsTheRest) {
  Rig rig;
  const auto good = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up"));
  const auto bad = rig.motion->queue(line(shifted(rig.start(), {3, 0, 0}), "far"));
  const auto after = rig.motion->queue(joint(rig.from, "back"));
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(good), MoveState::done);
  EXPECT_EQ(rig.motion->state_of(bad), MoveState::failed);
  EXPECT_EQ(rig.motion->problem_of(bad)->code, "unreachable");
  EXPECT_EQ(rig.motion->state_of(after), MoveState::discarded);
  const auto again = rig.motion->queue(joint(rig.from, "back"));
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(again), MoveState::done);
}

TEST(RobotMotion, AHeldMoveWaitsAndADiscardedOneIsForgotten) {
  Rig rig;
  const auto id = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.2}), "up"));
  const auto next = rig.motion->queue(joint(rig.from, "back"));
  rig.pass(200);
  rig.controller.verdict.speed = 0;
  rig.pass(2000);
  const Values held = rig.commanded();
  rig.pass(500);
  EXPECT_EQ(rig.commanded(), held);
  EXPECT_EQ(rig.motion->state_of(id), MoveState::running);
  rig.controller.verdict.discard = true;
  rig.pass(4);
  rig.controller.verdict.discard = false;
  rig.controller.verdict.speed = 1;
  rig.pass(100);
  EXPECT_EQ(rig.motion->state_of(id), MoveState::discarded);
  EXPECT_EQ(rig.motion->state_of(next), MoveState::discarded);
  EXPECT_TRUE(rig.motion->idle());
  EXPECT_EQ(rig.commanded(), held);
}

TEST(RobotMotion, AMoveIsEndedOnItsPathAndTheNextBeginsThere) {
  Rig rig;
  const auto id = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.2}), "up"));
  rig.motion->queue(joint(rig.from, "never"));
  rig.pass(200);
  rig.motion->end(id);
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(id), MoveState::done);
  const Vec3 by = rig.tcp().position - rig.start().position;
  EXPECT_LE(std::hypot(by.x, by.y), 1e-6) << "it left the line";
  EXPECT_LT(by.z, 0.1975);
  const auto back = rig.motion->queue(joint(rig.from, "back"));
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(back), MoveState::done);
  for (std::size_t j = 0; j < rig.from.size(); ++j) EXPECT_NEAR(rig.commanded()[j], rig.from[j], 1e-9);
}

/// A line, an arc-like blend and a joint move, interrupted in the middle: other moves come in between, and the robot
/// goes on along the path from where it was stopped.
TEST(RobotMotion, SuspendedMovesGoOnFromTheirPlaceOnTheirPath) {
  const auto queue_all = [](Rig& rig) {
    rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.2}), "up", 0.02));
    rig.motion->queue(line(shifted(rig.start(), {0.1, 0, 0.2}), "aside"));
    return rig.motion->queue(joint(rig.from, "back"));
  };
  Rig whole;
  queue_all(whole);
  whole.motion->close();
  std::vector<Vec3> way;  // uninterrupted
  for (int i = 0; i < 20000 && !(i > 10 && whole.motion->idle()); ++i) whole.pass(1), way.push_back(whole.tcp().position);
  for (const int when : {1, 150, 300, 520}) {
    Rig rig;
    const auto last = queue_all(rig);
    rig.motion->close();
    rig.pass(when);
    rig.motion->suspend();
    for (int i = 0; i < 2000 && !rig.motion->suspended(); ++i) rig.pass(1);
    ASSERT_TRUE(rig.motion->suspended());
    EXPECT_EQ(rig.motion->state_of(last), MoveState::running);
    const Values held = rig.commanded();
    const auto between = rig.motion->queue(joint({0, -1.5, 1.5, 0, 0.5, 0}, "elsewhere"));
    for (int i = 0; i < 20000 && rig.motion->state_of(between) == MoveState::running; ++i) rig.pass(1);
    EXPECT_EQ(rig.motion->state_of(between), MoveState::done);
    EXPECT_EQ(rig.motion->state_of(last), MoveState::running);
    EXPECT_FALSE(rig.motion->idle());
    rig.motion->resume();
    bool was_there = false;
    for (int i = 0; i < 20000 && !rig.motion->resumed(); ++i) {
      rig.pass(1);
      double most = 0;
      for (std::size_t j = 0; j < held.size(); ++j) most = std::max(most, std::abs(rig.commanded()[j] - held[j]));
      was_there = was_there || most < 1e-9;
    }
    ASSERT_TRUE(rig.motion->resumed());
    EXPECT_TRUE(was_there) << "it came back to where it was stopped";
    for (int i = 0, cycle = 0; i < 20000 && !rig.motion->idle(); ++i) {
      rig.pass(1);
      if (++cycle % 16 != 0) continue;
      double nearest = 1;
      for (std::size_t k = 1; k < way.size(); ++k) {  // distance from the uninterrupted way
        const Vec3 a = way[k - 1], d = way[k] - a;
        const double l = dot(d, d);
        const double t = l > 0 ? std::clamp(dot(rig.tcp().position - a, d) / l, 0.0, 1.0) : 0;
        nearest = std::min(nearest, norm(rig.tcp().position - (a + t * d)));
      }
      EXPECT_LT(nearest, 2e-6);
    }
    EXPECT_EQ(rig.motion->state_of(last), MoveState::done);
    for (std::size_t j = 0; j < held.size(); ++j) EXPECT_NEAR(rig.commanded()[j], rig.from[j], 1e-9);
    const auto next = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.05}), "next"));
    rig.until_idle();
    EXPECT_EQ(rig.motion->state_of(next), MoveState::done);
  }
}

TEST(RobotMotion, SuspendedMovesAreDiscardedWithTheRest) {
  Rig rig;
  const auto id = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.2}), "up"));
  rig.pass(200);
  rig.motion->suspend();
  for (int i = 0; i < 2000 && !rig.motion->suspended(); ++i) rig.pass(1);
  rig.motion->drop();
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(id), MoveState::discarded);
  const auto next = rig.motion->queue(joint(rig.from, "back"));
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(next), MoveState::done);
}

TEST(RobotMotion, AWayBackThatIsDiscardedIsAFailureOnce) {
  Rig rig;
  rig.motion->suspend();
  rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.05}), "aside"));
  for (int i = 0; i < 5000; ++i) rig.pass(1);
  rig.motion->resume();
  rig.pass(20);
  rig.motion->drop();
  EXPECT_TRUE(rig.motion->resumed());
  EXPECT_TRUE(rig.motion->take_return_failure());
  EXPECT_FALSE(rig.motion->take_return_failure());
}

TEST(RobotMotion, AStandingRobotReturnsToItsPlace) {
  Rig rig;
  rig.motion->suspend();
  EXPECT_TRUE(rig.motion->suspended());
  rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.05}), "aside"));
  for (int i = 0; i < 5000; ++i) rig.pass(1);
  rig.motion->resume();
  for (int i = 0; i < 5000 && !rig.motion->resumed(); ++i) rig.pass(1);
  EXPECT_TRUE(rig.motion->resumed());
  for (std::size_t j = 0; j < rig.from.size(); ++j) EXPECT_NEAR(rig.commanded()[j], rig.from[j], 1e-9);
}

TEST(RobotMotion, ReturnsAtThePaceOfTheMovesInBetween) {
  Rig rig;
  rig.motion->suspend();
  Move aside = joint({0, -1.5, 1.5, 0, 0.5, 0}, "aside");
  aside.speed = 0.1;
  const auto id = rig.motion->queue(std::move(aside));
  int out = 0, back = 0;
  for (; out < 50000 && rig.motion->state_of(id) == MoveState::running; ++out) rig.pass(1);
  rig.motion->resume();
  for (; back < 50000 && !rig.motion->resumed(); ++back) rig.pass(1);
  ASSERT_TRUE(rig.motion->resumed());
  EXPECT_GT(back, 0.9 * out);
}

/// The next move begins where the robot will stand, not at the end of a move that was dropped.
TEST(RobotMotion, AMoveEndedBeforeItsBeginLeavesNoTrace) {
  Rig rig;
  rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up"));
  rig.pass(4);
  const auto dropped = rig.motion->queue(line(shifted(rig.start(), {0, 0.1, 0.1}), "aside"));
  rig.pass(4);
  rig.motion->end(dropped);
  const auto next = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.05}), "next"));
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(next), MoveState::done);
  EXPECT_NEAR(norm(rig.tcp().position - shifted(rig.start(), {0, 0, 0.05}).position), 0, 1e-6);
}

TEST(RobotMotion, AMoveQueuedWhileAnotherOneIsEndedBeginsWhereThatStops) {
  Rig rig;
  const auto ended = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.2}), "up"));
  rig.pass(250);
  rig.motion->end(ended);
  const auto next = rig.motion->queue(line(shifted(rig.start(), {0, 0.05, 0.05}), "next"));
  rig.pass(1);
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(next), MoveState::done);
  EXPECT_NEAR(norm(rig.tcp().position - shifted(rig.start(), {0, 0.05, 0.05}).position), 0, 1e-6);
}

TEST(RobotMotion, PlansBesideTheOneWhoAsks) {
  Rig rig;
  rig.holds_jobs = true;
  const auto id = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up"));
  rig.pass(20);
  ASSERT_EQ(rig.jobs.size(), 1u);
  EXPECT_EQ(rig.commanded(), rig.from);
  rig.jobs.front()();
  rig.until_idle();
  EXPECT_EQ(rig.motion->state_of(id), MoveState::done);
  // Dropped while it is planned, it is never carried out.
  const Values here = rig.commanded();
  const auto dropped = rig.motion->queue(joint(rig.from, "back"));
  rig.pass(2);
  rig.motion->drop();
  rig.jobs.back()();
  rig.pass(100);
  EXPECT_EQ(rig.commanded(), here);
  EXPECT_EQ(rig.motion->state_of(dropped), MoveState::discarded);
}

TEST(RobotMotion, TellsHowFarAMoveHasCome) {
  Rig rig;
  const auto id = rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up"));
  EXPECT_TRUE(std::isinf(rig.motion->travel(id, id).left));
  rig.pass(150);
  const Travel travel = rig.motion->travel(id, id);
  EXPECT_NEAR(travel.covered, norm(rig.tcp().position - rig.start().position), 1e-4);
  EXPECT_NEAR(travel.covered + travel.left, 0.1, 1e-6);
  EXPECT_NEAR(travel.elapsed, 0.15, 0.003);
  rig.until_idle();
  EXPECT_EQ(rig.motion->travel(id, id).left, 0);
}

// The status of the controller is that of the motion before until it begins the next one.
TEST(RobotMotion, AMoveThatHasNotBegunHasComeNowhere) {
  Rig rig;
  rig.motion->queue(line(shifted(rig.start(), {0, 0, 0.1}), "up"));
  const auto back = rig.motion->queue(line(rig.start(), "back"));
  double before = 0;
  for (int i = 0; i < 20000 && !rig.motion->idle(); ++i) {
    rig.motion->tick(rig.controller.time());
    const Travel travel = rig.motion->travel(back, back);
    if (rig.motion->state_of(back) != MoveState::running) break;
    EXPECT_LE(travel.elapsed, before + 0.003) << "in cycle " << i;
    EXPECT_LE(rig.motion->move_under_way(), back);
    before = travel.elapsed;
    rig.controller.update();
  }
  EXPECT_GT(before, 0.1);
}

TEST(RobotMotion, MovesInStepBeginAndEndTogether) {
  Rig left, right;
  const auto step = std::make_shared<InStep>(2);
  const auto slow = left.motion->queue(line(shifted(left.start(), {0, 0, 0.2}), "far"), nullptr, step);
  for (int i = 0; i < 60; ++i) left.pass(1), right.pass(1);
  EXPECT_EQ(left.commanded(), left.from) << "it waits for the other";
  const auto quick = right.motion->queue(line(shifted(right.start(), {0, 0.02, 0}), "near"), nullptr, step);
  int left_begins = -1, right_begins = -1, left_ends = -1, right_ends = -1;
  for (int i = 0; i < 4000 && (left_ends < 0 || right_ends < 0); ++i) {
    left.pass(1), right.pass(1);
    if (left_begins < 0 && left.commanded() != left.from) left_begins = i;
    if (right_begins < 0 && right.commanded() != right.from) right_begins = i;
    if (left_ends < 0 && left.motion->state_of(slow) == MoveState::done) left_ends = i;
    if (right_ends < 0 && right.motion->state_of(quick) == MoveState::done) right_ends = i;
  }
  EXPECT_GT(left_begins, 0);
  EXPECT_EQ(left_begins, right_begins);
  EXPECT_LE(std::abs(left_ends - right_ends), 1);
  EXPECT_GT(left_ends, left_begins + 100);
}

TEST(RobotMotion, WhereOneInStepCannotGoNobodyGoes) {
  Rig left, right;
  const auto step = std::make_shared<InStep>(2);
  const auto good = left.motion->queue(line(shifted(left.start(), {0, 0, 0.2}), "up"), nullptr, step);
  const auto bad = right.motion->queue(line(shifted(right.start(), {5, 0, 0}), "far"), nullptr, step);
  for (int i = 0; i < 60; ++i) left.pass(1), right.pass(1);
  EXPECT_EQ(right.motion->state_of(bad), MoveState::failed);
  EXPECT_EQ(left.motion->state_of(good), MoveState::discarded);
  EXPECT_EQ(left.commanded(), left.from);
}

}  // namespace
}  // namespace polyarm::moves::robot_motion_test
