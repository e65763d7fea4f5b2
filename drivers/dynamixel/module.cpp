#include "drivers/dynamixel/dynamixel.hpp"

POLYARM_DRIVER(polyarm::dynamixel::DynamixelComponent)
