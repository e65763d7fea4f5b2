#pragma once
// rcpputils installs its folder rcppmath below its own name.
#include "rcppmath/clamp.hpp"
