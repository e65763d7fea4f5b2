#pragma once
#include <cstddef>
#include <vector>

namespace rsl {
/// Lists of a fixed capacity are plain lists here.
template <typename T, std::size_t>
using StaticVector = std::vector<T>;
template <typename T>
const std::vector<T>& to_vector(const std::vector<T>& all) {
  return all;
}
}  // namespace rsl
