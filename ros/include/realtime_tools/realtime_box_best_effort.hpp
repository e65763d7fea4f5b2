#pragma once
#include "polyarm_ros/standard.hpp"
#include "realtime_tools/realtime_box_best_effort.h"
