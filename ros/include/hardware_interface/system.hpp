#pragma once
#include "hardware_interface/system_interface.hpp"
