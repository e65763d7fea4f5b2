#pragma once
#include "hardware_interface/hardware_base.hpp"

namespace hardware_interface {

class SystemInterface : public HardwareBase {
 public:
  RCLCPP_SHARED_PTR_ALIASES_(SystemInterface)
};

}  // namespace hardware_interface
