#pragma once
/// Nodes as components are not loaded by Polyarm.
#include "polyarm_ros/standard.hpp"
#define RCLCPP_COMPONENTS_REGISTER_NODE(TYPE)
