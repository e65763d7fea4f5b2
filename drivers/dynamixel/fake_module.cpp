#include "drivers/dynamixel/dynamixel.hpp"
#include "drivers/servo_bus/fake_servos.hpp"

using Fake = polyarm::servo_bus::FakeServos<polyarm::dynamixel::DynamixelComponent,
                                            polyarm::servo_bus::Wire::dynamixel>;
POLYARM_DRIVER(Fake)
