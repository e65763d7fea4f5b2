#pragma once
#include "rclcpp_action/create_server.hpp"
