#pragma once
#include "hardware_interface/hardware_base.hpp"

namespace hardware_interface {

class SensorInterface : public HardwareBase {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(SensorInterface)
};

}  // namespace hardware_interface
