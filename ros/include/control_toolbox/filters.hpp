#pragma once
#include "polyarm_ros/standard.hpp"
namespace filters {
/// `alpha` is the share of the new value, 0 to 1.
template <typename T>
T exponentialSmoothing(const T& raw, const T& last, double alpha) {
  return alpha * raw + (1 - alpha) * last;
}
}  // namespace filters
