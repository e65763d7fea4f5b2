/// Controllers files of ROS users in a cell: what one controller lacks concerns no other.
#include "tests/cell/requests_cell.hpp"

namespace polyarm {
namespace {

using test::error_of;
using test::Json;
using test::LockStepCell;

/// How many problems among the cell's events say this.
int problems_with(LockStepCell& cell, const std::string& piece) {
  int out = 0;
  for (const protocol::Event& event : cell.cell().events().events())
    out += event.event == "problem" && event.what->find(piece) != std::string::npos;
  return out;
}

TEST(RosControllers, OneThatCannotBeConfiguredIsNamedAndTheOthersStart) {
  LockStepCell cell(R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    elsewhere: {type: joint_trajectory_controller/JointTrajectoryController}
    torque: {type: effort_controllers/JointGroupEffortController}
    grip: {type: position_controllers/GripperActionController}
    nothing: {params_file: []}
    slip: {type: JointTrajectoryController}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters: {joints: [joint_1, joint_2], command_interfaces: [position], state_interfaces: [position]}
elsewhere:
  ros__parameters: {joints: [left_joint_1], command_interfaces: [position], state_interfaces: [position]}
torque:
  ros__parameters: {joints: [joint_3]}
grip:
  ros__parameters: {stall_timeout: never}
)");
  cell.run(0.05);
  EXPECT_EQ(cell.state_of("follow"), "active");
  EXPECT_EQ(cell.state_of("states"), "active");
  for (const char* name : {"elsewhere", "torque", "grip"}) {
    EXPECT_EQ(cell.state_of(name), "unconfigured") << name;
    EXPECT_GE(problems_with(cell, "the controller '" + std::string(name) + "' is left unconfigured: "), 1)
        << name;
  }
  for (const char* name : {"nothing", "slip"}) {
    EXPECT_EQ(cell.state_of(name), "gone") << name;
    EXPECT_GE(problems_with(cell, "the controller '" + std::string(name) + "' is left out: "), 1) << name;
  }
}

constexpr const char* kGrippers = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    old: {type: position_controllers/GripperActionController}
    new: {type: parallel_gripper_action_controller/GripperActionController}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
old:
  ros__parameters: {joint: joint_5, goal_tolerance: 0.001}
new:
  ros__parameters: {joint: joint_6, goal_tolerance: 0.001}
)";

TEST(RosControllers, BothGrippersAnswerGoalsInTheirOwnWords) {
  LockStepCell cell(kGrippers);
  cell.run(0.05);
  for (const auto& [to, message] : {std::pair{"old/gripper_cmd", "{command: {position: 0.3, max_effort: 5}}"},
                                    {"new/gripper_cmd", "{command: {name: [joint_6], position: [0.3]}}"}}) {
    const auto answers =
        cell.give(Json{{"request", "send"}, {"to", to}, {"message", message}, {"goal", true}});
    cell.run(0.5);
    ASSERT_GE(answers->size(), 2u) << to;
    const Json& last = answers->back()["result"];
    EXPECT_EQ(last["status"], "succeeded") << last;
    EXPECT_EQ(last["reached_goal"], true);
    EXPECT_FALSE(last.contains("note")) << "it was judged by its tolerance";
    const Json& first = (*answers)[1]["result"];
    if (first.contains("feedback")) {
      EXPECT_TRUE(first["feedback"]["position"].is_number()) << first;
    }
  }
}

using RosRequests = test::RequestsTest;

TEST_F(RosRequests, AWatchIsToldWhyNothingComes) {
  cell.run(0.05);
  EXPECT_TRUE(
      cell.ask({{"request", "control.state"}, {"name", "follow"}, {"state", "inactive"}})["ok"].get<bool>());
  const auto patient = cell.give(
      Json{{"request", "watch"}, {"name", "follow/controller_state"}, {"rate", 50}, {"patience", 0.5}});
  const auto silent =
      cell.give(Json{{"request", "watch"}, {"name", "follow/controller_state"}, {"rate", 50}});
  cell.run(1.5);
  const auto waiting = [](const std::vector<Json>& answers) {
    return std::count_if(answers.begin(), answers.end(),
                         [](const Json& a) { return a["result"].contains("waiting"); });
  };
  ASSERT_EQ(waiting(*patient), 1) << "it is told once";
  const Json& told = patient->back()["result"];
  EXPECT_EQ(told["waiting"], "follow/controller_state");
  EXPECT_EQ(told["state"], "inactive");
  EXPECT_NE(told["what"].get<std::string>().find("its controller is inactive"), std::string::npos) << told;
  EXPECT_NE(told["advice"].get<std::string>().find("control state follow active"), std::string::npos) << told;
  EXPECT_EQ(waiting(*silent), 0) << "only who asks is told";
  EXPECT_TRUE(
      cell.ask({{"request", "control.state"}, {"name", "follow"}, {"state", "active"}})["ok"].get<bool>());
  cell.run(0.2);
  EXPECT_TRUE(patient->back()["result"].contains("joint_names")) << patient->back();
}

TEST_F(RosRequests, AGoalThatEndsFarOffWithoutTolerancesSaysSo) {
  // The measured joint is off by what nobody judges.
  cell.run(0.05);
  const auto push = [&](double from, double to) {  // slower than what would be a fault
    for (int i = 1; i <= 20; ++i) {
      test::FailingMock::pushed = from + (to - from) * i / 20;
      cell.run(0.01);
    }
  };
  push(0, 0.097);
  const Json goal{{"joint_names", {"joint_1", "joint_2"}},
                  {"points", {{{"positions", {0.2, 0}}, {"time_from_start", 0.3}}}}};
  const Json result = cell.result({{"request", "send"}, {"to", "follow"}, {"message", goal}, {"goal", true}});
  push(0.097, 0);
  EXPECT_EQ(result["status"], "succeeded") << result;
  EXPECT_EQ(result["joint"], "arm/joint_1");
  EXPECT_NEAR(std::abs(result["off_by"].get<double>()), 0.097, 1e-3);
  EXPECT_NE(result["note"].get<std::string>().find("no goal tolerance is set"), std::string::npos) << result;
  EXPECT_EQ(problems_with(cell, "follow: goal 1 succeeded, but arm/joint_1 is"), 1);
  const Json near = cell.result({{"request", "send"}, {"to", "follow"}, {"message", goal}, {"goal", true}});
  EXPECT_EQ(near["status"], "succeeded") << near;
  EXPECT_FALSE(near.contains("note")) << near;
}

TEST_F(RosRequests, AGoalOnAHeldCellIsToldOrRefusedAsItsControllerSays) {
  cell.run(0.05);
  EXPECT_TRUE(cell.ask({{"request", "control.hold"}})["ok"].get<bool>());
  cell.run(0.2);
  const Json goal{{"joint_names", {"joint_1", "joint_2"}},
                  {"points", {{{"positions", {0.2, 0}}, {"time_from_start", 0.3}}}}};
  const Json send{{"request", "send"}, {"to", "follow"}, {"message", goal}, {"goal", true}};
  const auto waits = cell.give(send);
  cell.run(0.5);
  EXPECT_EQ(problems_with(cell, "a goal for 'follow' comes while the cell is held ("), 1);
  EXPECT_TRUE(cell.ask({{"request", "param.set"},
                        {"name", "follow"},
                        {"values", {{"reject_goals_when_held", true}}}})["ok"]
                  .get<bool>());
  const Json refused = cell.ask(send);
  EXPECT_EQ(error_of(refused), "held") << refused;
  EXPECT_NE(test::what_of(refused).find("is refused while the cell is held ("), std::string::npos) << refused;
  EXPECT_TRUE(cell.ask({{"request", "control.resume"}})["ok"].get<bool>());
  cell.run(1);
  EXPECT_EQ(waits->back()["result"]["status"], "succeeded") << waits->back();
}

}  // namespace
}  // namespace polyarm
