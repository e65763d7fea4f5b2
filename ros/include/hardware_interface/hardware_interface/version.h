#pragma once
#include "hardware_interface/version.h"
