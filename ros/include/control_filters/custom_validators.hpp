#pragma once
#include "control_toolbox/custom_validators.hpp"
#include "rclcpp/rclcpp.hpp"
