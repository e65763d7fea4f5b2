#include "drivers/yaskawa/component.hpp"

POLYARM_DRIVER(polyarm::yaskawa::YaskawaComponent)
