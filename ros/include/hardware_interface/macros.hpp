#pragma once
#include <stdexcept>
#include <string>

#include "polyarm_ros/standard.hpp"
#include "rcpputils/pointer_traits.hpp"

#ifdef _WIN32
#define __PRETTY_FUNCTION__ __FUNCSIG__
#endif
#define THROW_ON_NULLPTR(pointer)                                                                 \
  if (!pointer) {                                                                                 \
    throw std::runtime_error(std::string(__PRETTY_FUNCTION__) + " failed: " #pointer " is null"); \
  }
#define THROW_ON_NOT_NULLPTR(pointer)                                                                 \
  if (pointer) {                                                                                      \
    throw std::runtime_error(std::string(__PRETTY_FUNCTION__) + " failed: " #pointer " is not null"); \
  }
