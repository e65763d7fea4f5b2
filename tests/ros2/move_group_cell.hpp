#pragma once
/// A UR5e that answers as a move_group, and requests of MoveIt's clients.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/ros2/own_cell.hpp"
#include "tests/ros2/ros2_cell.hpp"

namespace polyarm::ros2 {

inline const std::string kMoveIt = "moveit_msgs/srv/";
inline constexpr int kSucceeded = 4, kCanceled = 5, kAborted = 6;
inline const std::vector<std::string> kUrJoints = {"shoulder_pan_joint", "shoulder_lift_joint",
                                                   "elbow_joint",        "wrist_1_joint",
                                                   "wrist_2_joint",      "wrist_3_joint"};
inline const std::vector<double> kThere = {0.6, -1.4, 1.3, -1.2, -1.4, 0.3};

inline json joint_goal(const std::vector<double>& q) {
  json out = json::array();
  for (std::size_t i = 0; i < q.size(); ++i)
    out.push_back({{"joint_name", kUrJoints[i]},
                   {"position", q[i]},
                   {"tolerance_above", 1e-4},
                   {"tolerance_below", 1e-4},
                   {"weight", 1.0}});
  return {{"joint_constraints", out}};
}
inline json state(const std::vector<double>& q) {
  return {{"joint_state", {{"name", kUrJoints}, {"position", q}}}};
}
inline json box(const std::string& id, const std::vector<double>& size, double x, double y, double z) {
  return {{"id", id},
          {"header", {{"frame_id", "world"}}},
          {"primitives", json::array({{{"type", 1}, {"dimensions", size}}})},
          {"primitive_poses", json::array({{{"orientation", {{"w", 1.0}}}}})},
          {"pose", {{"position", {{"x", x}, {"y", y}, {"z", z}}}, {"orientation", {{"w", 1.0}}}}}};
}

class MoveGroupCellTest : public ::testing::Test {
 protected:
  void SetUp() override {
    cell_.emplace(test::OwnCell::Files{
        {"cell.yaml",
         "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: "
         "mock}\ncontrollers: "
         "controllers.yaml\nactivate: [joint_state_broadcaster, arm_controller]\nros2: {move_group: true}\n"},
        {"controllers.yaml", kControllers}});
    client_ = &*cell_->client;
    states_ = client_->listen("/joint_states", "sensor_msgs/JointState");
    ASSERT_TRUE(wait([&] { return states_->heard(); }));
  }
  void TearDown() override {
    states_.reset();
    cell_.reset();
  }
  json call(const std::string& service, const std::string& type, const json& request = json::object()) {
    return client_->call(service, type, request);
  }
  json send(int number, const json& goal, const std::string& action = "/move_action",
            const std::string& type = "moveit_msgs/action/MoveGroup") {
    return client_->call(action + "/_action/send_goal", type + "_SendGoal",
                         {{"goal_id", id(number)}, {"goal", goal}});
  }
  json result(int number, const std::string& action = "/move_action",
              const std::string& type = "moveit_msgs/action/MoveGroup") {
    return client_->call(action + "/_action/get_result", type + "_GetResult", {{"goal_id", id(number)}});
  }
  json move(int number, const json& goal) {
    EXPECT_EQ(send(number, goal)["accepted"], true);
    return result(number);
  }
  bool apply(const json& scene) {
    return call("/apply_planning_scene", kMoveIt + "ApplyPlanningScene", {{"scene", scene}})["success"];
  }
  std::vector<double> joints() const {
    const json latest = states_->latest();
    std::vector<double> out;
    for (const std::string& joint : kUrJoints) {
      const auto at = std::find(latest["name"].begin(), latest["name"].end(), joint);
      out.push_back(latest["position"][static_cast<std::size_t>(at - latest["name"].begin())].get<double>());
    }
    return out;
  }
  bool is_at(const std::vector<double>& q) const {
    const std::vector<double> now = joints();
    return std::equal(q.begin(), q.end(), now.begin(),
                      [](double a, double b) { return std::abs(a - b) < 2e-3; });
  }

  std::optional<test::OwnCell> cell_;
  Client* client_ = nullptr;
  std::unique_ptr<Client::Listener> states_;
};

}  // namespace polyarm::ros2
