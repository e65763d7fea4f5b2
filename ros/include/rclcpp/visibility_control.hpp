#pragma once
#include "polyarm_ros/standard.hpp"
#include "rclcpp/macros.hpp"
