#include "drivers/feetech/feetech.hpp"
#include "drivers/servo_bus/fake_servos.hpp"

using Fake =
    polyarm::servo_bus::FakeServos<polyarm::feetech::FeetechComponent, polyarm::servo_bus::Wire::feetech>;
POLYARM_DRIVER(Fake)
