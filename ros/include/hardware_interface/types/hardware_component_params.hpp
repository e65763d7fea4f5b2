#pragma once
#include <memory>

#include "hardware_interface/hardware_info.hpp"
#include "rclcpp/executors.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/rclcpp.hpp"

namespace hardware_interface {

struct HardwareComponentParams {
  HardwareInfo hardware_info;
  rclcpp::Logger logger = rclcpp::get_logger("hardware");
  rclcpp::Clock::SharedPtr clock;
  std::weak_ptr<rclcpp::Executor> executor;
  std::string node_namespace;
};
struct HardwareComponentInterfaceParams {
  HardwareInfo hardware_info;
  std::weak_ptr<rclcpp::Executor> executor;
  std::string node_namespace;
};

}  // namespace hardware_interface
