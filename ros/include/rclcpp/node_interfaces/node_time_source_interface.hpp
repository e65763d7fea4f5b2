#pragma once
#include "rclcpp/node_interfaces/node_interfaces.hpp"
