#include "drivers/cia402/fake.hpp"

POLYARM_DRIVER(polyarm::cia402::FakeCia402)
