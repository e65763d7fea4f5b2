#include "drivers/yaskawa/fake.hpp"

POLYARM_DRIVER(polyarm::yaskawa::FakeYaskawa)
