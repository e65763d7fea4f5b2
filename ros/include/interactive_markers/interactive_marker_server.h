#pragma once
#include "interactive_markers/interactive_marker_server.hpp"
