#pragma once
// rcpputils installs its folder rcppmath below its own name.
#include "rcppmath/rolling_mean_accumulator.hpp"
