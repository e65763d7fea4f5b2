#pragma once
#include "hardware_interface/hardware_component_interface.hpp"

namespace hardware_interface {

class SystemInterface : public HardwareComponentInterface {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(SystemInterface)
};

}  // namespace hardware_interface
