#include "drivers/kuka/fake.hpp"

POLYARM_DRIVER(polyarm::kuka::FakeKuka)
