#pragma once
#include "rclcpp/node.hpp"
#include "rclcpp_action/client.hpp"
