/// The cell as MoveIt's move_group: objects, constraints, bad input, cancelled goals, several robots.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/ros2/move_group_cell.hpp"

namespace polyarm::ros2 {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::string kExecuteType = "moveit_msgs/action/ExecuteTrajectory";

json request_to(const json& goal) {
  return {{"group_name", "arm"}, {"goal_constraints", json::array({goal})}};
}
json pose_goal(const json& pose, double position = 1e-3, double angle = 1e-2) {
  return {
      {"position_constraints",
       json::array({{{"header", {{"frame_id", "world"}}},
                     {"link_name", "tool0"},
                     {"constraint_region",
                      {{"primitives", json::array({{{"type", 2}, {"dimensions", json::array({position})}}})},
                       {"primitive_poses",
                        json::array({{{"position", pose["position"]}, {"orientation", {{"w", 1.0}}}}})}}},
                     {"weight", 1.0}}})},
      {"orientation_constraints", json::array({{{"header", {{"frame_id", "world"}}},
                                                {"link_name", "tool0"},
                                                {"orientation", pose["orientation"]},
                                                {"absolute_x_axis_tolerance", angle},
                                                {"absolute_y_axis_tolerance", angle},
                                                {"absolute_z_axis_tolerance", angle},
                                                {"weight", 1.0}}})}};
}

class MoveGroupGoals : public MoveGroupCellTest {
 protected:
  json plan(const json& request) {
    return call("/plan_kinematic_path", kMoveIt + "GetMotionPlan",
                {{"motion_plan_request", request}})["motion_plan_response"];
  }
  int code(const json& request) { return plan(request)["error_code"]["val"].get<int>(); }
  json fk(const std::vector<double>& q) {
    return call("/compute_fk", kMoveIt + "GetPositionFK",
                {{"header", {{"frame_id", "world"}}},
                 {"fk_link_names", {"tool0"}},
                 {"robot_state", state(q)}})["pose_stamped"][0]["pose"];
  }
  static std::vector<double> end_of(const json& plan) {
    return plan["trajectory"]["joint_trajectory"]["points"].back()["positions"].get<std::vector<double>>();
  }
};

TEST_F(MoveGroupGoals, APoseIsReached) {
  const json wanted = fk(kThere);
  const json found = plan(request_to(pose_goal(wanted)));
  ASSERT_EQ(found["error_code"]["val"], 1) << found["error_code"];
  const json reached = fk(end_of(found));
  for (const char* axis : {"x", "y", "z"})
    EXPECT_NEAR(reached["position"][axis].get<double>(), wanted["position"][axis].get<double>(), 1e-3);
}

TEST_F(MoveGroupGoals, APositionAloneAndAlternativesAreReached) {
  json position = pose_goal(fk(kThere));
  position.erase("orientation_constraints");
  EXPECT_EQ(code(request_to(position)), 1);
  json far = pose_goal(fk(kThere));
  far["position_constraints"][0]["constraint_region"]["primitive_poses"][0]["position"] = {
      {"x", 9.0}, {"y", 0.0}, {"z", 0.0}};
  EXPECT_EQ(code(request_to(far)), -31);
  json both = request_to(far);
  both["goal_constraints"].push_back(joint_goal(kThere));
  EXPECT_EQ(code(both), 1);
}

TEST_F(MoveGroupGoals, ObjectsAreAvoidedNamedAndRemoved) {
  const json at = fk(kThere)["position"];
  ASSERT_TRUE(apply(
      {{"is_diff", true},
       {"world",
        {{"collision_objects", json::array({box("crate", {0.2, 0.2, 0.2}, at["x"], at["y"], at["z"])})}}}}));
  const json blocked = plan(request_to(joint_goal(kThere)));
  EXPECT_EQ(blocked["error_code"]["val"], -12) << blocked["error_code"];
  EXPECT_NE(blocked["error_code"]["message"].get<std::string>().find("crate"), std::string::npos);
  const json scene = call("/get_planning_scene", kMoveIt + "GetPlanningScene",
                          {{"components", {{"components", 24}}}})["scene"];
  ASSERT_EQ(scene["world"]["collision_objects"].size(), 1u) << scene["world"];
  EXPECT_EQ(scene["world"]["collision_objects"][0]["id"], "crate");
  json removed = box("crate", {}, 0, 0, 0);
  removed["operation"] = 1;
  removed["primitives"] = removed["primitive_poses"] = json::array();
  ASSERT_TRUE(apply({{"is_diff", true}, {"world", {{"collision_objects", json::array({removed})}}}}));
  EXPECT_EQ(code(request_to(joint_goal(kThere))), 1);
}

TEST_F(MoveGroupGoals, AnAttachedObjectGoesWithTheRobotAndStaysWhereItIsLetGo) {
  json held = box("bar", {0.02, 0.02, 0.8}, 0, 0, 0.45);
  held["header"]["frame_id"] = "tool0";
  ASSERT_TRUE(
      apply({{"is_diff", true},
             {"robot_state",
              {{"is_diff", true},
               {"attached_collision_objects", json::array({{{"link_name", "tool0"}, {"object", held}}})}}}}));
  ASSERT_TRUE(apply(
      {{"is_diff", true},
       {"world", {{"collision_objects", json::array({box("slab", {1.2, 1.2, 0.1}, 0.8, 0, -0.45)})}}}}));
  const std::vector<double> low{0, -0.6, 1.2, -2.2, -1.57, 0};
  const json answer = call("/check_state_validity", kMoveIt + "GetStateValidity",
                           {{"group_name", "arm"}, {"robot_state", state(low)}});
  EXPECT_EQ(answer["valid"], false) << "the bar reaches into the slab";
  EXPECT_NE(answer["contacts"].dump().find("bar"), std::string::npos) << answer;
  json let_go = held;
  let_go["operation"] = 1;
  let_go["primitives"] = let_go["primitive_poses"] = json::array();
  ASSERT_TRUE(apply(
      {{"is_diff", true},
       {"robot_state",
        {{"is_diff", true},
         {"attached_collision_objects", json::array({{{"link_name", "tool0"}, {"object", let_go}}})}}}}));
  const json scene = call("/get_planning_scene", kMoveIt + "GetPlanningScene")["scene"];
  EXPECT_TRUE(scene["robot_state"]["attached_collision_objects"].empty());
  ASSERT_EQ(scene["world"]["collision_objects"].size(), 2u);
  EXPECT_EQ(call("/check_state_validity", kMoveIt + "GetStateValidity",
                 {{"group_name", "arm"}, {"robot_state", state(low)}})["valid"],
            true);
}

TEST_F(MoveGroupGoals, APathConstraintIsKeptOrRefused) {
  json goal = fk(kThere);
  goal["position"]["z"] = goal["position"]["z"].get<double>() - 0.08;
  json upright = pose_goal(goal)["orientation_constraints"];
  json request = request_to(pose_goal(goal));
  request["start_state"] = state(kThere);
  request["path_constraints"]["orientation_constraints"] = upright;
  const json found = plan(request);
  ASSERT_EQ(found["error_code"]["val"], 1) << found["error_code"];
  for (const json& point : found["trajectory"]["joint_trajectory"]["points"]) {
    const json pose = fk(point["positions"].get<std::vector<double>>());
    double dot = 0;
    for (const char* axis : {"x", "y", "z", "w"})
      dot += pose["orientation"][axis].get<double>() * goal["orientation"][axis].get<double>();
    EXPECT_GT(std::abs(dot), 0.9999);
    if (HasFailure()) break;
  }
  json turned = upright;
  turned[0]["orientation"] = {{"x", 1.0}, {"y", 0.0}, {"z", 0.0}, {"w", 0.0}};
  turned[0]["absolute_x_axis_tolerance"] = 0.01;
  request["path_constraints"]["orientation_constraints"] = turned;
  EXPECT_EQ(code(request), -11);
}

TEST_F(MoveGroupGoals, ALineIsFollowedAndCarriedOut) {
  ASSERT_EQ(move(7, {{"request", request_to(joint_goal(kThere))}})["result"]["error_code"]["val"], 1);
  ASSERT_TRUE(wait([&] { return is_at(kThere); }));
  json to = fk(joints());
  to["position"]["z"] = to["position"]["z"].get<double>() - 0.05;
  const json path = call("/compute_cartesian_path", kMoveIt + "GetCartesianPath",
                         {{"header", {{"frame_id", "world"}}},
                          {"group_name", "arm"},
                          {"link_name", "tool0"},
                          {"waypoints", json::array({to})},
                          {"max_step", 0.01},
                          {"avoid_collisions", true}});
  ASSERT_EQ(path["error_code"]["val"], 1) << path["error_code"];
  EXPECT_DOUBLE_EQ(path["fraction"].get<double>(), 1);
  ASSERT_EQ(send(1, {{"trajectory", path["solution"]}}, "/execute_trajectory", kExecuteType)["accepted"],
            true);
  const json done = result(1, "/execute_trajectory", kExecuteType);
  EXPECT_EQ(done["result"]["error_code"]["val"], 1) << done;
  EXPECT_NEAR(fk(joints())["position"]["z"].get<double>(), to["position"]["z"].get<double>(), 1e-3);
  json far = to;
  far["position"]["x"] = 5.0;
  const json cut = call("/compute_cartesian_path", kMoveIt + "GetCartesianPath",
                        {{"header", {{"frame_id", "world"}}},
                         {"group_name", "arm"},
                         {"waypoints", json::array({far})},
                         {"max_step", 0.01}});
  EXPECT_LT(cut["fraction"].get<double>(), 0.9);
}

TEST_F(MoveGroupGoals, ACancelledMoveStopsAndSaysSo) {
  json goal{{"request", request_to(joint_goal({2.5, -1.4, 1.3, -1.2, -1.4, 0.3}))}};
  goal["request"]["max_velocity_scaling_factor"] = 0.05;
  const std::vector<double> before = joints();
  ASSERT_EQ(send(1, goal)["accepted"], true);
  ASSERT_TRUE(wait([&] { return std::abs(joints()[0] - before[0]) > 0.01; }));
  EXPECT_EQ(call("/move_action/_action/cancel_goal", "action_msgs/srv/CancelGoal",
                 {{"goal_info", {{"goal_id", id(1)}}}})["return_code"],
            0);
  const json ended = result(1);
  EXPECT_EQ(ended["status"], kCanceled) << ended["status"];
  EXPECT_EQ(ended["result"]["error_code"]["val"], -7);
  EXPECT_LT(joints()[0], 2.4);
}

TEST_F(MoveGroupGoals, ANewerGoalTakesThePlaceOfTheOneUnderWay) {
  json slow{{"request", request_to(joint_goal({2.5, -1.4, 1.3, -1.2, -1.4, 0.3}))}};
  slow["request"]["max_velocity_scaling_factor"] = 0.05;
  const std::vector<double> before = joints();
  ASSERT_EQ(send(1, slow)["accepted"], true);
  ASSERT_TRUE(wait([&] { return std::abs(joints()[0] - before[0]) > 0.01; }));
  const json second = move(2, {{"request", request_to(joint_goal(kThere))}});
  EXPECT_EQ(second["result"]["error_code"]["val"], 1) << second["result"]["error_code"];
  EXPECT_EQ(result(1)["result"]["error_code"]["val"], -7);
}

TEST_F(MoveGroupGoals, ANewerGoalBeginsWhereAFastRobotHasStopped) {
  const json far{{"request", request_to(joint_goal({2.5, -1.4, 1.3, -1.2, -1.4, 0.3}))}};
  const std::vector<double> before = joints();
  ASSERT_EQ(send(1, far)["accepted"], true);
  ASSERT_TRUE(wait([&] { return std::abs(joints()[0] - before[0]) > 0.3; }));
  const json second = move(2, {{"request", request_to(joint_goal(kThere))}});
  EXPECT_EQ(second["result"]["error_code"]["val"], 1) << second["result"]["error_code"];
  EXPECT_EQ(result(1)["result"]["error_code"]["val"], -7);
}

TEST_F(MoveGroupGoals, AnObjectInTheWayStopsTheMotion) {
  json goal{{"request", request_to(joint_goal({2.5, -1.4, 1.3, -1.2, -1.4, 0.3}))}};
  goal["request"]["max_velocity_scaling_factor"] = 0.1;
  const std::vector<double> before = joints();
  const json at = fk({2.5, -1.4, 1.3, -1.2, -1.4, 0.3})["position"];
  ASSERT_EQ(send(1, goal)["accepted"], true);
  ASSERT_TRUE(wait([&] { return std::abs(joints()[0] - before[0]) > 0.01; }));
  ASSERT_TRUE(apply(
      {{"is_diff", true},
       {"world",
        {{"collision_objects", json::array({box("late", {0.2, 0.2, 0.2}, at["x"], at["y"], at["z"])})}}}}));
  const json ended = result(1);
  EXPECT_EQ(ended["result"]["error_code"]["val"], -3) << ended["result"]["error_code"];
  EXPECT_NE(ended["result"]["error_code"]["message"].get<std::string>().find("late"), std::string::npos);
}

/// Each gets its code and a sentence, and the cell goes on.
TEST_F(MoveGroupGoals, BadInputIsRefusedWithItsCode) {
  const auto expect = [&](int wanted, const json& request, const char* what) {
    const json answer = plan(request)["error_code"];
    EXPECT_EQ(answer["val"], wanted) << what << answer;
    EXPECT_FALSE(answer["message"].get<std::string>().empty()) << what;
  };
  expect(-16, {{"group_name", "arm"}}, "no goal");
  json unknown = request_to(joint_goal(kThere));
  unknown["group_name"] = "leg";
  expect(-15, unknown, "unknown group");
  json nan = request_to(joint_goal(kThere));
  nan["goal_constraints"][0]["joint_constraints"][2]["position"] = kNan;
  expect(-16, nan, "NaN joint");
  json joint = request_to(joint_goal(kThere));
  joint["goal_constraints"][0]["joint_constraints"][2]["joint_name"] = "knee";
  expect(-16, joint, "unknown joint");
  expect(-16, request_to(joint_goal({50, 0, 0, 0, 0, 0})), "beyond the limits");
  json pose = fk(kThere);
  json link = request_to(pose_goal(pose));
  link["goal_constraints"][0]["position_constraints"][0]["link_name"] = "knee";
  expect(-18, link, "unknown link");
  json frame = request_to(pose_goal(pose));
  frame["goal_constraints"][0]["position_constraints"][0]["header"]["frame_id"] = "moon";
  expect(-21, frame, "unknown frame");
  json bad = pose;
  bad["position"]["x"] = kNan;
  expect(-16, request_to(pose_goal(bad)), "NaN position");
  bad = pose;
  bad["orientation"]["x"] = kNan;
  expect(-16, request_to(pose_goal(bad)), "NaN orientation");
  json start = request_to(joint_goal(kThere));
  start["start_state"] = state({kNan, 0, 0, 0, 0, 0});
  expect(-17, start, "NaN start");
  json visible = request_to(joint_goal(kThere));
  visible["goal_constraints"][0]["visibility_constraints"] = json::array({json::object()});
  expect(-16, visible, "visibility");
  json many = request_to(joint_goal(kThere));
  for (int i = 0; i < 100; ++i) many["goal_constraints"].push_back(joint_goal(kThere));
  expect(-16, many, "too many goals");
  EXPECT_EQ(code(request_to(joint_goal(kThere))), 1);
}

TEST_F(MoveGroupGoals, BadScenesChangeNothing) {
  const auto add = [&](const json& object) {
    return apply(
        {{"is_diff", true},
         {"world", {{"collision_objects", json::array({box("good", {0.1, 0.1, 0.1}, 2, 2, 2), object})}}}});
  };
  EXPECT_FALSE(add(box("nan", {kNan, 1, 1}, 0, 0, 0)));
  EXPECT_FALSE(add(box("negative", {-1, 1, 1}, 0, 0, 0)));
  EXPECT_FALSE(add(box("flat", {1, 1}, 0, 0, 0)));
  EXPECT_FALSE(add(box("lost", {1, 1, 1}, kNan, 0, 0)));
  EXPECT_FALSE(add(box("", {1, 1, 1}, 0, 0, 0)));
  json mesh = box("mesh", {}, 0, 0, 0);
  mesh["primitives"] = mesh["primitive_poses"] = json::array();
  mesh["meshes"] = json::array({{{"vertices", json::array({{{"x", 0.0}}})},
                                 {"triangles", json::array({{{"vertex_indices", {0, 1, 2}}}})}}});
  mesh["mesh_poses"] = json::array({{{"orientation", {{"w", 1.0}}}}});
  EXPECT_FALSE(add(mesh));
  json many = json::array();
  for (int i = 0; i < 600; ++i) many.push_back(box("b" + std::to_string(i), {0.1, 0.1, 0.1}, 3, 3, 3));
  EXPECT_FALSE(apply({{"is_diff", true}, {"world", {{"collision_objects", many}}}}));
  const json scene = call("/get_planning_scene", kMoveIt + "GetPlanningScene")["scene"];
  EXPECT_TRUE(scene["world"]["collision_objects"].empty()) << "a refused message changes nothing";
}

TEST_F(MoveGroupGoals, ATrajectoryFromElsewhereIsNotCarriedOut) {
  const std::vector<double> before = joints();
  json points = json::array(
      {{{"positions", kThere}, {"time_from_start", 0.0}}, {{"positions", before}, {"time_from_start", 5.0}}});
  ASSERT_EQ(
      send(1, {{"trajectory", {{"joint_trajectory", {{"joint_names", kUrJoints}, {"points", points}}}}}},
           "/execute_trajectory", kExecuteType)["accepted"],
      true);
  EXPECT_EQ(result(1, "/execute_trajectory", kExecuteType)["result"]["error_code"]["val"], -4);
  EXPECT_EQ(joints(), before);
}

}  // namespace
}  // namespace polyarm::ros2
