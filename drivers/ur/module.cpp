#include "drivers/ur/component.hpp"

POLYARM_DRIVER(polyarm::ur::UrComponent)
