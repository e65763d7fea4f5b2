#pragma once
#include <string>
#include <unordered_map>

#include "joint_limits/joint_limits.hpp"
#include "rclcpp/node_options.hpp"

namespace controller_interface {

struct ControllerInterfaceParams {
  std::string controller_name, robot_description;
  unsigned int update_rate = 0, controller_manager_update_rate = 0;
  std::string node_namespace;
  rclcpp::NodeOptions node_options;
  std::unordered_map<std::string, joint_limits::JointLimits> hard_joint_limits;
  std::unordered_map<std::string, joint_limits::SoftJointLimits> soft_joint_limits;
};

}  // namespace controller_interface
