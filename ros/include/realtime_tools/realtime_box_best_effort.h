#pragma once
#include "realtime_tools/realtime_thread_safe_box.hpp"
