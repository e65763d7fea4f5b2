#pragma once
/// Which of the turns of a joint a value is meant in. Used inside this room only.
#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// The turn of `value` of joint `i` nearest to `near` that is inside the limits; where no turn is, the one
/// least outside. A joint that cannot turn keeps its value.
inline double unwound(const Chain& chain, std::size_t i, double value, double near) noexcept {
  const double period = chain.period(i), lower = chain.lower()[i], upper = chain.upper()[i];
  if (!(period > 0) || !std::isfinite(near)) return value;
  // Half a turn away is as near on either side; rounding must not decide which it is.
  value += period * std::round((near - value) / period - 1e-9);
  if (value < lower) value += period * std::ceil((lower - value) / period - 1e-12);
  if (value > upper) {
    const double down = period * std::ceil((value - upper) / period - 1e-12);
    const double over = value - upper, under = lower - (value - down);
    if (under <= 1e-12 || under < over) value -= down;
  }
  return value;
}

/// How far joint `i` is outside its limits at `value`, 0 inside.
inline double excess(const Chain& chain, std::size_t i, double value) noexcept {
  return std::max({0.0, chain.lower()[i] - value, value - chain.upper()[i]});
}

}  // namespace polyarm::kinematics
