#include "drivers/pca9685/component.hpp"

POLYARM_DRIVER(polyarm::drivers::Pca9685Component)
