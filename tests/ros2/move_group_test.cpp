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

/// A cell with two robots, the second one at `x`.
test::OwnCell::Files two_robots(const std::string& x) {
  return {{"cell.yaml",
           "polyarm: cell/1\nrobots:\n"
           "  left: {model: universal_robots/ur3, hardware: mock}\n"
           "  right: {model: universal_robots/ur3, hardware: mock, at: [" +
               x +
               ", 0, 0], rpy: [0, 0, 180deg]}\n"
               "scene: scene.yaml\nros2: {move_group: true}\n"},
          {"scene.yaml", "polyarm: scene/1\nfixtures:\n  post: {box: [0.1, 0.1, 0.4], at: [0, 0.4, 0.2]}\n"}};
}

/// The error code of a motion to a joint goal.
json moved(test::OwnCell& cell, const std::string& robot) {
  const std::string action = "/" + robot + "/move_action/_action/", type = "moveit_msgs/action/MoveGroup";
  const json goal{{"request",
                   {{"group_name", robot},
                    {"goal_constraints", json::array({joint_goal({0, -1.3, 0.3, -1.5, 0, 0.2})})}}}};
  const json accepted =
      cell.client->call(action + "send_goal", type + "_SendGoal", {{"goal_id", id(1)}, {"goal", goal}});
  if (accepted["accepted"] != true) return accepted;
  return cell.client->call(action + "get_result", type + "_GetResult",
                           {{"goal_id", id(1)}})["result"]["error_code"];
}

TEST(TwoMoveGroups, MoveTheirRobots) {
  test::OwnCell cell(two_robots("2"));
  for (const char* robot : {"left", "right"}) {
    const json code = moved(cell, robot);
    EXPECT_EQ(code["val"], 1) << robot << code;
  }
}

/// Each robot has its names; the other one, and a fixture, are obstacles.
TEST(TwoMoveGroups, NameEachOtherAndTheFixtures) {
  test::OwnCell cell(two_robots("0.5"));
  const json scene = cell.call("/left/get_planning_scene", kMoveIt + "GetPlanningScene")["scene"];
  ASSERT_EQ(scene["world"]["collision_objects"].size(), 1u) << scene["world"];
  EXPECT_EQ(scene["world"]["collision_objects"][0]["id"], "post");
  const auto valid = [&](double pan, double lift) {
    return cell.call("/left/check_state_validity", kMoveIt + "GetStateValidity",
                     {{"robot_state", state({pan, lift, 0, -1.5, 0, 0})}});
  };
  const auto hits = [](const json& answer, const std::string& what) {
    for (const json& contact : answer["contacts"])
      if (contact.dump().find(what) != std::string::npos) return true;
    return false;
  };
  EXPECT_EQ(valid(0, -1.57)["valid"], true);
  EXPECT_TRUE(hits(valid(0, -0.02), "right/")) << valid(0, -0.02);
  EXPECT_TRUE(hits(valid(1.57, -0.02), "post")) << valid(1.57, -0.02);
  // They stand so near that their hands overlap where they begin.
  for (const std::string robot : {"left", "right"}) {
    const json code = moved(cell, robot);
    const std::string other = robot == "left" ? "right/" : "left/";
    EXPECT_EQ(code["val"], -10) << robot << code;
    EXPECT_NE(code["message"].get<std::string>().find(other), std::string::npos) << robot << code;
  }
}

}  // namespace
}  // namespace polyarm::ros2
