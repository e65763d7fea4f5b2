/// Override, hold, step back, resume and stop of a whole cell, asked for as people do.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/cell/requests_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::error_of;
using test::FailingMock;
using test::Json;
using test::LockStepCell;

constexpr const char* kControllers = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters:
    joints: [joint_1, joint_2]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
)";

class MotionRequests : public ::testing::Test {
 protected:
  LockStepCell cell{kControllers};
  timing::TimedPath path;

  controllers::JointTrajectoryController& follow() {
    return dynamic_cast<controllers::JointTrajectoryController&>(
        *cell.cell().loop().controllers().find("follow"));
  }
  /// Both joints along a path with a corner.
  void go() {
    const std::vector<double> at{command("joint_1"), command("joint_2")};
    const std::vector<trajectory::MotionLimits> limits(2, trajectory::MotionLimits::symmetric(1, 4, 40));
    const std::vector<paths::JointWaypoint> way{
        {at}, {{at[0] + 0.8, at[1]}, 0.2}, {{at[0] + 0.8, at[1] + 0.6}}};
    path = timing::timed(std::move(paths::joint_lines(way).sections.front()), limits);
    auto goal = std::make_unique<controllers::TrajectoryGoal>();
    goal->id = follow().new_goal_id();
    goal->planned = std::make_unique<timing::PathFollower>(path, limits, follow().period());
    ASSERT_TRUE(follow().follow(goal));
  }
  double command(const std::string& joint) { return cell.value_of("commands", "arm/" + joint + "/position"); }
  double speed() { return follow().status().speed.load(); }
  Json state() { return cell.result({{"request", "health"}})["state"]; }
  void expect_on_path() {
    std::vector<double> q(2);
    std::size_t hint = 0;
    path.sample(follow().status().time.load(), q, {}, {}, {}, hint);
    EXPECT_EQ(command("joint_1"), q[0]);
    EXPECT_EQ(command("joint_2"), q[1]);
  }
};

TEST_F(MotionRequests, AnOverrideHoldsForEveryMotionUntilItIsChanged) {
  cell.run(0.1);
  const Json told = cell.result({{"request", "control.override"}, {"percent", 50}});
  EXPECT_EQ(told["percent"], 50);
  EXPECT_EQ(cell.told("override 50 %"), 1);
  go();
  cell.run(0.4);
  EXPECT_NEAR(speed(), 0.5, 1e-9);
  cell.result({{"request", "control.override"}, {"percent", 0}});
  cell.run(0.6);
  EXPECT_EQ(speed(), 0);
  EXPECT_EQ(state(), "running");
  EXPECT_EQ(cell.result({{"request", "health"}})["override_percent"], 0);
  expect_on_path();
  cell.result({{"request", "control.override"}, {"percent", 100}});
  cell.run(4);
  EXPECT_EQ(follow().status().finished.load(), 1u);
  EXPECT_EQ(cell.result({{"request", "control.override"}})["percent"], 100);
}

TEST_F(MotionRequests, AnOverrideOutOfRangeIsRefused) {
  EXPECT_EQ(error_of(cell.ask({{"request", "control.override"}, {"percent", 101}})), "bad-argument");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.override"}, {"percent", -1}})), "bad-argument");
  EXPECT_EQ(cell.result({{"request", "control.override"}})["percent"], 100);
}

TEST_F(MotionRequests, StepsBackOnThePathIsHeldAgainAndResumesFromThere) {
  cell.run(0.1);
  go();
  cell.run(0.7);
  EXPECT_EQ(error_of(cell.ask({{"request", "control.back"}})), "wrong-state");
  cell.result({{"request", "control.hold"}});
  cell.run(0.6);
  ASSERT_EQ(state(), "held");
  const double held = follow().status().time.load();
  const Json back = cell.result({{"request", "control.back"}, {"time", 0.3}});
  EXPECT_EQ(back["state"], "held") << back;
  EXPECT_NEAR(follow().status().time.load(), held - 0.3, 2e-3);
  EXPECT_TRUE(back["joints"].contains("arm/joint_1"));
  expect_on_path();
  const Json further = cell.result({{"request", "control.back"}, {"distance", 0.05}});
  EXPECT_EQ(further["state"], "held") << further;
  std::size_t hint = 0;
  EXPECT_NEAR(
      path.profile().at(held - 0.3, hint).s - path.profile().at(follow().status().time.load(), hint).s, 0.05,
      2e-3);
  cell.result({{"request", "control.back"}, {"time", 60}});
  EXPECT_NEAR(follow().status().time.load(), 0, 1e-3);
  cell.result({{"request", "control.resume"}});
  cell.run(4);
  EXPECT_EQ(follow().status().finished.load(), 1u);
}

TEST_F(MotionRequests, WithoutAPathThereIsNothingToStepBackOn) {
  cell.run(0.1);
  cell.result({{"request", "control.hold"}});
  cell.run(0.1);
  EXPECT_EQ(error_of(cell.ask({{"request", "control.back"}})), "nothing-to-step-back");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.back"}, {"time", -1}})), "bad-argument");
  EXPECT_EQ(state(), "held");
}

TEST_F(MotionRequests, AHoldStopsAStepBack) {
  cell.run(0.1);
  go();
  cell.run(0.7);
  cell.result({{"request", "control.hold"}});
  cell.run(0.6);
  const double held = follow().status().time.load();
  const auto back = cell.give(Json{{"request", "control.back"}, {"time", 0.4}});
  cell.run(0.5);
  EXPECT_EQ(cell.cell().snapshot().state, control::RunState::backing);
  cell.cell().loop().supervisor().latch().request(realtime::StopKind::controlled);
  cell.run(0.3);
  EXPECT_EQ(state(), "held");
  EXPECT_LT(follow().status().time.load(), held);
  EXPECT_GT(follow().status().time.load(), held - 0.3);
  EXPECT_FALSE(back->empty());
}

TEST_F(MotionRequests, AStopTellsWhatItTook) {
  cell.run(0.1);
  go();
  cell.run(0.6);
  const double from = command("joint_1");
  cell.result({{"request", "control.hold"}});
  cell.run(1);
  const double way = command("joint_1") - from;
  ASSERT_EQ(cell.cell().stops().size(), 1u);
  const cell::StopReport& stop = cell.cell().stops().front();
  EXPECT_GT(stop.time_s, 0.15) << "1 rad/s at 4 rad/s²";
  EXPECT_LT(stop.time_s, 0.5);
  EXPECT_EQ(stop.category, 2);
  ASSERT_FALSE(stop.joints.empty());
  EXPECT_EQ(stop.joints[0].name, "arm/joint_1");
  EXPECT_NEAR(stop.joints[0].way, way, 0.01) << "to one tick";
  ASSERT_EQ(stop.tcps.size(), 1u);
  EXPECT_GT(stop.tcps[0].way, 0.01);
  const Json last = cell.result({{"request", "health"}})["last_stop"];
  EXPECT_EQ(last["time_s"], stop.time_s);
  cell.result({{"request", "control.resume"}});
  cell.run(4);
  cell.result({{"request", "control.hold"}});
  cell.run(1);
  EXPECT_EQ(cell.cell().stops().size(), 1u) << "nothing moved in the second one";
}

TEST_F(MotionRequests, AStopOfCategory1SwitchesTheDrivesOffWhenAllStands) {
  cell.run(0.1);
  go();
  cell.run(0.6);
  EXPECT_EQ(error_of(cell.ask({{"request", "control.stop"}, {"category", 0}})), "bad-argument");
  const Json answer = cell.result({{"request", "control.stop"}, {"category", 1}});
  EXPECT_EQ(answer["inactive"].size(), 1u) << answer;
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  for (const Json& component : cell.result({{"request", "hardware.list"}}))
    EXPECT_EQ(component["state"], "inactive");
  ASSERT_EQ(cell.cell().stops().size(), 1u);
  EXPECT_EQ(cell.cell().stops().front().category, 1);
}

TEST_F(MotionRequests, WhoWasMovedWhileHeldIsNotResumedUnlessAskedAgain) {
  cell.run(0.1);
  go();
  cell.run(0.6);
  cell.result({{"request", "control.hold"}});
  cell.run(1);
  FailingMock::pushed = 0.03;
  cell.run(0.1);
  const Json refused = cell.ask({{"request", "control.resume"}});
  EXPECT_EQ(error_of(refused), "moved-while-held");
  EXPECT_NE(refused["error"]["what"].get<std::string>().find("joint_1 was moved by +0.03"), std::string::npos)
      << refused;
  EXPECT_EQ(error_of(cell.ask({{"request", "control.back"}})), "moved-while-held");
  EXPECT_EQ(state(), "held");
  FailingMock::pushed = 0.001;
  cell.run(0.1);
  cell.result({{"request", "control.resume"}});
  cell.run(0.01);
  EXPECT_EQ(state(), "running");
  cell.result({{"request", "control.hold"}});
  cell.run(1);
  FailingMock::pushed = -0.03;
  cell.run(0.1);
  EXPECT_EQ(error_of(cell.ask({{"request", "control.resume"}})), "moved-while-held");
  cell.result({{"request", "control.resume"}, {"anyway", true}});
  cell.run(0.01);
  EXPECT_EQ(state(), "running");
  FailingMock::pushed = 0;
}

}  // namespace
}  // namespace polyarm
