#pragma once
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
template <typename Input, typename Find, typename Replace>
std::string find_and_replace(const Input& input, const Find& what, const Replace& with) {
  std::string out(input);
  const std::string from(what), to(with);
  if (from.empty()) return out;
  for (auto at = out.find(from); at != std::string::npos; at = out.find(from, at + to.size()))
    out.replace(at, from.size(), to);
  return out;
}
}  // namespace rcpputils
