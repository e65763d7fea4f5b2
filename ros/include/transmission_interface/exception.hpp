#pragma once
#include "polyarm_ros/standard.hpp"
#include "transmission_interface/transmission_interface_exception.hpp"
