#pragma once
#include "polyarm_ros/standard.hpp"
#include "tf2/transform_datatypes.hpp"
