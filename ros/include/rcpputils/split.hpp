#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
inline std::vector<std::string> split(const std::string& text, char mark, bool skip_empty = false) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(mark, begin), text.size());
    if (end > begin || !skip_empty) out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}
}  // namespace rcpputils
