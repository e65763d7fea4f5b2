#pragma once
/// Serialized messages and identities of requests, too.
#include "rclcpp/qos.hpp"
#include "rclcpp/serialized_message.hpp"
#include "rclcpp/service.hpp"
