#pragma once
#include <csignal>
#include <iomanip>
#include <iostream>
#include <memory>

#include "polyarm_ros/standard.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/executors.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp/parameter.hpp"
#include "rclcpp/parameter_client.hpp"
#include "rclcpp/rate.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp/utilities.hpp"
#include "rclcpp/version.h"
#include "rcutils/logging_macros.h"
