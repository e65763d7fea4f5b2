#pragma once
#include "polyarm_ros/standard.hpp"
#define RCPPUTILS_PUBLIC
#define RCPPUTILS_LOCAL
#define RCPPUTILS_PUBLIC_TYPE
