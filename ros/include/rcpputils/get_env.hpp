#pragma once
#include "rcpputils/env.hpp"
