#pragma once
/// Driver for Dynamixel servos of the X series on a serial line. See servo_bus/component.hpp for interfaces
/// and units.
#include "drivers/dynamixel/family.hpp"
#include "drivers/dynamixel/protocol2.hpp"
#include "drivers/servo_bus/component.hpp"

namespace polyarm::dynamixel {

/// The X series with Protocol 2.0.
class DynamixelComponent : public servo_bus::ServoComponent {
 public:
  DynamixelComponent() : ServoComponent(x_family(), std::make_unique<Protocol2>()) {}
};

}  // namespace polyarm::dynamixel
