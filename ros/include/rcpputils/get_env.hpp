#pragma once
#include "polyarm_ros/standard.hpp"
#include "rcpputils/env.hpp"
