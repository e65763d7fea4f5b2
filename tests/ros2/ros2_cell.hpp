#pragma once
/// The command with --ros2 on a UR5e, and a client of its graph.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/support/command.hpp"

namespace polyarm::ros2 {

using test::Client;
using test::json;
using test::wait;

inline const char* const kControllers = R"(controller_manager:
  ros__parameters:
    update_rate: 500
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    forward: {type: forward_command_controller/ForwardCommandController}
arm_controller:
  ros__parameters:
    joints: &joints [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints: {goal_time: 0.5}
forward:
  ros__parameters:
    joints: *joints
    interface_name: position
)";

/// A UR5e on the mock, in a domain of its own.
class Ros2Cell : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "cell.yaml")
        << "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: "
           "universal_robots/ur5e, hardware: mock}\ncontrollers: controllers.yaml\n"
           "activate: [joint_state_broadcaster, arm_controller]\n";
    std::ofstream(folder_ / "controllers.yaml") << kControllers;
    ::setenv("ROS_DOMAIN_ID", std::to_string(domain_).c_str(), 1);
    command_.emplace(std::vector<std::string>{"run", folder_.string(), "--ros2", "--no-socket"});
    ASSERT_TRUE(command_->wait_for("ROS 2: domain " + std::to_string(domain_) + ", this machine alone"))
        << command_->wait().output;
    client_.emplace(domain_);
  }
  void TearDown() override {
    client_.reset();
    command_.reset();
    std::filesystem::remove_all(folder_);
  }
  json call(const std::string& service, const std::string& type, const json& request = json::object()) {
    return client_->call(service, type, request);
  }
  std::map<std::string, std::string> states() {
    std::map<std::string, std::string> out;
    const json listed =
        call("/controller_manager/list_controllers", "controller_manager_msgs/srv/ListControllers");
    for (const json& c : listed["controller"]) out[c["name"]] = c["state"];
    return out;
  }

  const std::uint32_t domain_ = test::own_domain();
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("polyarm_ros2_" + std::to_string(::getpid()));
  std::optional<polyarm::test::Command> command_;
  std::optional<Client> client_;
};

inline json goal_to(double first, double seconds) {
  const std::vector<double> there{first, -1.5, 1.5, -1.5, -1.5, 0};
  return {{"trajectory",
           {{"joint_names",
             {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint",
              "wrist_3_joint"}},
            {"points", json::array({{{"positions", there}, {"time_from_start", seconds}}})}}}};
}
inline json id(int n) {
  std::vector<int> uuid(16, 7);
  uuid[15] = n;
  return {{"uuid", uuid}};
}

inline const std::string kAction = "/arm_controller/follow_joint_trajectory/_action/";
inline const std::string kType = "control_msgs/action/FollowJointTrajectory";
inline const std::string kParameters = "rcl_interfaces/srv/", kManager = "controller_manager_msgs/srv/";

}  // namespace polyarm::ros2
