#pragma once
/// Selects the turn of a joint value. Private to the rooms descent and ik. Radians or metres; any thread.
#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// The turn of `value` of joint `i` nearest to `near` that is inside the limits; if there is none, the one
/// least outside. A joint that cannot turn keeps its value.
inline double unwound(const Chain& chain, std::size_t i, double value, double near) noexcept {
  const double period = chain.period(i), lower = chain.lower()[i], upper = chain.upper()[i];
  if (!(period > 0) || !std::isfinite(near)) return value;
  // Half a turn is equally near on either side; rounding must not decide.
  value += period * std::round((near - value) / period - 1e-9);
  if (value < lower) value += period * std::ceil((lower - value) / period - 1e-12);
  if (value > upper) {
    const double down = period * std::ceil((value - upper) / period - 1e-12);
    const double over = value - upper, under = lower - (value - down);
    if (under <= 1e-12 || under < over) value -= down;
  }
  return value;
}

/// The distance of `value` of joint `i` beyond its limits; 0 inside.
inline double excess(const Chain& chain, std::size_t i, double value) noexcept {
  return std::max({0.0, chain.lower()[i] - value, value - chain.upper()[i]});
}

}  // namespace polyarm::kinematics
