#include "drivers/fanuc/fake.hpp"

POLYARM_DRIVER(polyarm::fanuc::FakeFanuc)
