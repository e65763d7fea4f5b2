#pragma once
#include "polyarm_ros/standard.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"
