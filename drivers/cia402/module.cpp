#include "drivers/cia402/component.hpp"

POLYARM_DRIVER(polyarm::cia402::Cia402Component)
