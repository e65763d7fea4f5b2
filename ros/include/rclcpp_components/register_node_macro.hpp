#pragma once
/// Nodes as components are not loaded by Polyarm.
#define RCLCPP_COMPONENTS_REGISTER_NODE(TYPE)
