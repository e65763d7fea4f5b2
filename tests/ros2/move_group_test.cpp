/// The cell as MoveIt's move_group: services and actions as clients of MoveIt use them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/ros2/move_group_cell.hpp"

namespace polyarm::ros2 {
namespace {

TEST_F(MoveGroupCellTest, PlansAndMovesToJointValues) {
  const json result = move(
      1, {{"request", {{"group_name", "arm"}, {"goal_constraints", json::array({joint_goal(kThere)})}}}});
  EXPECT_EQ(result["status"], kSucceeded) << result;
  EXPECT_EQ(result["result"]["error_code"]["val"], 1) << result["result"]["error_code"];
  EXPECT_GT(result["result"]["planned_trajectory"]["joint_trajectory"]["points"].size(), 10u);
  EXPECT_TRUE(wait([&] { return is_at(kThere); }));
}

TEST_F(MoveGroupCellTest, PlanOnlyMovesNothing) {
  const std::vector<double> before = joints();
  const json result =
      move(1, {{"request", {{"group_name", "arm"}, {"goal_constraints", json::array({joint_goal(kThere)})}}},
               {"planning_options", {{"plan_only", true}}}});
  EXPECT_EQ(result["status"], kSucceeded) << result;
  EXPECT_EQ(joints(), before);
}

TEST_F(MoveGroupCellTest, SolvesAndUndoesItself) {
  const json fk = call("/compute_fk", kMoveIt + "GetPositionFK",
                       {{"fk_link_names", {"tool0"}}, {"robot_state", state(kThere)}});
  ASSERT_EQ(fk["error_code"]["val"], 1) << fk;
  const json ik = call("/compute_ik", kMoveIt + "GetPositionIK",
                       {{"ik_request",
                         {{"group_name", "arm"},
                          {"robot_state", state(kThere)},
                          {"avoid_collisions", true},
                          {"pose_stamped", fk["pose_stamped"][0]}}}});
  ASSERT_EQ(ik["error_code"]["val"], 1) << ik["error_code"];
  for (std::size_t i = 0; i < kThere.size(); ++i)
    EXPECT_NEAR(ik["solution"]["joint_state"]["position"][i].get<double>(), kThere[i], 1e-6);
}

TEST_F(MoveGroupCellTest, TellsWhetherAStateIsValid) {
  const auto valid = [&](const std::vector<double>& q) {
    return call("/check_state_validity", kMoveIt + "GetStateValidity",
                {{"group_name", "arm"}, {"robot_state", state(q)}});
  };
  EXPECT_EQ(valid(kThere)["valid"], true);
  const json folded = valid({0, -1.5, 3.1, 0, 0, 0});
  EXPECT_EQ(folded["valid"], false) << folded;
  EXPECT_FALSE(folded["contacts"].empty());
}

TEST_F(MoveGroupCellTest, PublishesTheSrdf) {
  const auto heard = client_->listen("/robot_description_semantic", "std_msgs/String", {true, true, 1});
  ASSERT_TRUE(wait([&] { return heard->heard(); }));
  const std::string srdf = heard->latest()["data"];
  EXPECT_NE(srdf.find("<group name=\"arm\">"), std::string::npos) << srdf;
  EXPECT_NE(srdf.find("tip_link=\"tool0\""), std::string::npos) << srdf;
  EXPECT_NE(srdf.find("<disable_collisions"), std::string::npos) << srdf;
  EXPECT_NE(srdf.find("<group_state name=\"home\" group=\"arm\">"), std::string::npos) << srdf;
}

}  // namespace
}  // namespace polyarm::ros2
