#include "drivers/franka/fake.hpp"

POLYARM_DRIVER(polyarm::franka::FakeFranka)
