#include "drivers/abb/component.hpp"

POLYARM_DRIVER(polyarm::abb::AbbComponent)
