#pragma once
#include "rclcpp/qos.hpp"
