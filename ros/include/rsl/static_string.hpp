#pragma once
#include <cstddef>
#include <string>

namespace rsl {
/// Strings of a fixed capacity are plain strings here.
template <std::size_t>
using StaticString = std::string;
inline const std::string& to_string(const std::string& text) {
  return text;
}
}  // namespace rsl
