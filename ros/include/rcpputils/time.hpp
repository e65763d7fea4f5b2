#pragma once
#include <chrono>
#include <stdexcept>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
/// A span as nanoseconds; throws std::invalid_argument if it has no place there.
template <typename Rep, typename Ratio>
std::chrono::nanoseconds convert_to_nanoseconds(const std::chrono::duration<Rep, Ratio>& span) {
  using Wide = std::chrono::duration<long double, std::nano>;
  const Wide wide(span);
  if (wide > Wide(std::chrono::nanoseconds::max()) || wide < Wide(std::chrono::nanoseconds::min()))
    throw std::invalid_argument("the span is too long for nanoseconds");
  return std::chrono::duration_cast<std::chrono::nanoseconds>(span);
}
}  // namespace rcpputils
