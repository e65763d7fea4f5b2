#pragma once
#include "polyarm_ros/standard.hpp"
#include "rcppmath/rolling_mean_accumulator.hpp"

namespace rcpputils {
using rcppmath::RollingMeanAccumulator;
}  // namespace rcpputils
