#pragma once
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
/// Empty if it is not set.
inline std::string get_env_var(const char* name) {
  if (!name) throw std::runtime_error("the name of a variable is null");
  const char* value = std::getenv(name);
  return value ? value : "";
}
inline bool set_env_var(const char* name, const char* value) {
  if (!name || !*name) throw std::runtime_error("a variable has no name");
  const int failed = value ? ::setenv(name, value, 1) : ::unsetenv(name);
  if (failed) throw std::runtime_error(std::string("the variable ") + name + " cannot be set");
  return true;
}
}  // namespace rcpputils
