#include "drivers/sensors/serial_imu.hpp"

POLYARM_DRIVER(polyarm::sensors::SerialImu)
