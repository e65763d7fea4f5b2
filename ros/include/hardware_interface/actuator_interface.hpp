#pragma once
#include "hardware_interface/hardware_base.hpp"

namespace hardware_interface {

class ActuatorInterface : public HardwareBase {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(ActuatorInterface)
};

}  // namespace hardware_interface
