#pragma once
/// One clock: nanoseconds since the cell started, advanced by whole periods.
#include <cstdint>

namespace polyarm {

using Nanoseconds = std::int64_t;
constexpr double seconds(Nanoseconds t) {
  return static_cast<double>(t) * 1e-9;
}
constexpr Nanoseconds nanoseconds(double s) {
  return static_cast<Nanoseconds>(s * 1e9 + (s < 0 ? -0.5 : 0.5));
}

}  // namespace polyarm
