#include "drivers/mujoco/component.hpp"

POLYARM_DRIVER(polyarm::drivers::MujocoComponent)
