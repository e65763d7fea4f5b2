#pragma once
#include "urdf/model.hpp"
