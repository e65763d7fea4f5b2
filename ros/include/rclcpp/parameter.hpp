#pragma once
#include "rclcpp/parameter_value.hpp"
