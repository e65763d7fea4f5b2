#include "drivers/abb/fake.hpp"

POLYARM_DRIVER(polyarm::abb::FakeAbb)
