#pragma once
#include "realtime_tools/realtime_buffer.hpp"
