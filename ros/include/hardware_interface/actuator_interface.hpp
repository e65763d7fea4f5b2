#pragma once
#include "hardware_interface/hardware_component_interface.hpp"

namespace hardware_interface {

class ActuatorInterface : public HardwareComponentInterface {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(ActuatorInterface)
};

}  // namespace hardware_interface
