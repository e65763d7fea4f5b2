#include "drivers/franka/component.hpp"

POLYARM_DRIVER(polyarm::franka::FrankaComponent)
