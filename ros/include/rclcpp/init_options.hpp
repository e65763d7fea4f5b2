#pragma once
#include "rclcpp/utilities.hpp"
