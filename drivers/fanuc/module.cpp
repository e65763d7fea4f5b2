#include "drivers/fanuc/component.hpp"

POLYARM_DRIVER(polyarm::fanuc::FanucComponent)
