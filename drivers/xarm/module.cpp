#include "drivers/xarm/component.hpp"

POLYARM_DRIVER(polyarm::xarm::XarmComponent)
