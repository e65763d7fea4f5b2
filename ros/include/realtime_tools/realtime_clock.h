#pragma once
#include "realtime_tools/realtime_clock.hpp"
