#pragma once
#include "drivers/servo_bus/registers.hpp"

namespace polyarm::dynamixel {

/// The X series (XL430, XM430, XH540 and alike) under Protocol 2.0.
const servo_bus::Family& x_family();

}  // namespace polyarm::dynamixel
