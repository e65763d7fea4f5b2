#include "drivers/ur/fake.hpp"

POLYARM_DRIVER(polyarm::ur::FakeUr)
