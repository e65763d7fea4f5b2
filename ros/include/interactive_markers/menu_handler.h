#pragma once
#include "interactive_markers/menu_handler.hpp"
