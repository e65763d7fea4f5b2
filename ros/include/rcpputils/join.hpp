#pragma once
#include <sstream>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
template <typename Values>
std::string join(const Values& values, const std::string& between) {
  std::ostringstream out;
  bool first = true;
  for (const auto& each : values) {
    if (!first) out << between;
    out << each;
    first = false;
  }
  return out.str();
}
}  // namespace rcpputils
