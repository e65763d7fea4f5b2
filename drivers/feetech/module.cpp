#include "drivers/feetech/feetech.hpp"

POLYARM_DRIVER(polyarm::feetech::FeetechComponent)
