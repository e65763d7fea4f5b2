#pragma once
#include "message_filters/null_types.hpp"
