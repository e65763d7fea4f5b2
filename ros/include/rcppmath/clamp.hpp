#pragma once
#include <algorithm>

namespace rcppmath {
template <typename T>
const T& clamp(const T& value, const T& low, const T& high) {
  return std::clamp(value, low, high);
}
}  // namespace rcppmath
