#pragma once
/// Repeatable random joint values: the same seed gives the same values on every machine. Radians or metres.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// A small counter-based generator: the counter, scrambled by the finaliser of splitmix64 (Steele, Lea and
/// Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL) {}
  /// In [0, 1).
  double unit() noexcept {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  /// Skips `count` values.
  void skip(std::uint64_t count) noexcept { state_ += count * 0x9e3779b97f4a7c15ULL; }
  double between(double lower, double upper) noexcept { return lower + (upper - lower) * unit(); }

 private:
  std::uint64_t state_;
};

/// A random value of joint `i` within its limits. If the limits allow more than one turn, it is within the
/// one turn nearest zero; for a prismatic joint without limits, within one metre of zero or of its single
/// limit.
inline double random_value(const Chain& chain, std::size_t i, Random& random) noexcept {
  double lower = chain.lower()[i], upper = chain.upper()[i];
  const double half = chain.period(i) > 0 ? chain.period(i) / 2 : std::numbers::pi;
  const bool wide = chain.period(i) > 0 ? upper - lower > 2 * half : !std::isfinite(upper - lower);
  if (wide) {
    double center = 0;
    if (std::isfinite(lower)) center = std::max(center, lower + half);
    if (std::isfinite(upper)) center = std::min(center, upper - half);
    lower = center - half;
    upper = center + half;
  }
  return random.between(lower, upper);
}

}  // namespace polyarm::kinematics
