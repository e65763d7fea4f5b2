#pragma once
#include "rclcpp/executors.hpp"
