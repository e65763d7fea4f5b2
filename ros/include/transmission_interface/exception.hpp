#pragma once
#include "transmission_interface/transmission_interface_exception.hpp"
