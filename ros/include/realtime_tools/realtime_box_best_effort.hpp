#pragma once
#include "realtime_tools/realtime_box_best_effort.h"
