#pragma once
#include "hardware_interface/actuator_interface.hpp"
