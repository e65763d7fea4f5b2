#pragma once
#include "rcutils/macros.h"
