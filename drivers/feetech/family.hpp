#pragma once
/// The register map of Feetech STS and SMS servos. Const: any thread.
#include "drivers/servo_bus/registers.hpp"

namespace polyarm::feetech {

/// STS and SMS servos with a magnetic encoder of 4096 steps: STS3215 and similar.
const servo_bus::Family& sts_family();

}  // namespace polyarm::feetech
