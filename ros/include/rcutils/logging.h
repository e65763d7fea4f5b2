#pragma once
#include "rcutils/logging_macros.h"

using rcutils_ret_t = int;
using RCUTILS_LOG_SEVERITY = int;
#define RCUTILS_RET_OK 0
#define RCUTILS_LOG_SEVERITY_UNSET 0

/// All lines are written: levels of single loggers have no effect.
inline rcutils_ret_t rcutils_logging_set_logger_level(const char*, int) {
  return RCUTILS_RET_OK;
}
inline int rcutils_logging_get_logger_level(const char*) {
  return RCUTILS_LOG_SEVERITY_INFO;
}
