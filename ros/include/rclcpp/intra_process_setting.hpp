#pragma once
#include "rclcpp/qos_event.hpp"
