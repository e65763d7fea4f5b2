#pragma once
/// Polyarm records every interface without registration: these do nothing.
#include "polyarm_ros/standard.hpp"
#define REGISTER_ROS2_CONTROL_INTROSPECTION(ID, ENTITY) static_cast<void>(0);
#define UNREGISTER_ROS2_CONTROL_INTROSPECTION(ID) static_cast<void>(0);
#define CLEAR_ALL_ROS2_CONTROL_INTROSPECTION_REGISTRIES() static_cast<void>(0);
#define DEFAULT_REGISTER_ROS2_CONTROL_INTROSPECTION(ID, ENTITY) static_cast<void>(0);
