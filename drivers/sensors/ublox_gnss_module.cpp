#include "drivers/sensors/ublox_gnss.hpp"

POLYARM_DRIVER(polyarm::sensors::UbloxGnss)
