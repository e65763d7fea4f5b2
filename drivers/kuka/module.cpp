#include "drivers/kuka/component.hpp"

POLYARM_DRIVER(polyarm::kuka::KukaComponent)
