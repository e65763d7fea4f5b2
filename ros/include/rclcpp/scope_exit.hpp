#pragma once
#include "rcpputils/scope_exit.hpp"
#define RCLCPP_SCOPE_EXIT(...) RCPPUTILS_SCOPE_EXIT(__VA_ARGS__)
