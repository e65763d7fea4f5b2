#pragma once
/// The register map of the Dynamixel X series. Const: any thread.
#include "drivers/servo_bus/registers.hpp"

namespace polyarm::dynamixel {

/// The X series (XL430, XM430, XH540 and similar) with Protocol 2.0.
const servo_bus::Family& x_family();

}  // namespace polyarm::dynamixel
