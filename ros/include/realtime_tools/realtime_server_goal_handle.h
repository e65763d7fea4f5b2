#pragma once
#include "realtime_tools/realtime_server_goal_handle.hpp"
