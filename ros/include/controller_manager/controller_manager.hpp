#pragma once
/// Polyarm itself is the controller manager, so there is no class of it here. Packages include this header
/// for what it brings.
#include "controller_interface/chainable_controller_interface.hpp"
#include "controller_interface/controller_interface.hpp"
#include "hardware_interface/handle.hpp"
#include "pluginlib/class_loader.hpp"
#include "rclcpp/rclcpp.hpp"
