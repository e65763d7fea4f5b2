#pragma once
#include "hardware_interface/hardware_component_interface.hpp"

namespace hardware_interface {

class SensorInterface : public HardwareComponentInterface {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(SensorInterface)
};

}  // namespace hardware_interface
