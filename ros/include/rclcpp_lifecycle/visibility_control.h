#pragma once
#include "rclcpp/macros.hpp"
