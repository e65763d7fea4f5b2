#include "drivers/xarm/fake.hpp"

POLYARM_DRIVER(polyarm::xarm::FakeXarm)
