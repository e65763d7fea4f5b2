#pragma once
/// Sines and cosines of eight angles, rad. Private to the kernels.
#include <numbers>

#include "polyarm/simd/lanes.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

namespace POLYARM_LANES {

/// Sine and cosine to a few units in the last place, for angles up to 1e5. Subtracts whole quarter turns in
/// three pieces of pi/2 (Cody and Waite 1980); the polynomials are Taylor polynomials of the remainder, to
/// within rounding on [-pi/4, pi/4].
POLYARM_INLINE LaneAngle turn_by(const Lane& a) {
  constexpr double kHigh = 1.5707963267341256, kMiddle = 6.0771005063039e-11, kLow = 2.0222662487959506e-21;
  const Lane quarters = rounded(a * (2 / std::numbers::pi));
  const Lane r = ((a - quarters * kHigh) - quarters * kMiddle) - quarters * kLow;
  const Lane z = r * r;
  Lane s = z * 1.58938307283228937328e-10 - 2.50506947139990e-8;
  s = s * z + 2.75573136213857245213e-6;
  s = s * z - 1.98412698295895385996e-4;
  s = s * z + 8.33333333332211858878e-3;
  s = s * z - 1.66666666666666307295e-1;
  s = r + r * (z * s);
  Lane c = z * -1.13585365213876817300e-11 + 2.08757008419747316778e-9;
  c = c * z - 2.75573141792967388112e-7;
  c = c * z + 2.48015872888517045348e-5;
  c = c * z - 1.38888888888730564116e-3;
  c = c * z + 4.16666666666665929218e-2;
  c = 1.0 - (0.5 * z - z * (z * c));
  // The number of quarters modulo four: 0, 1/4, +-1/2, -1/4.
  const Lane part = off_whole(0.25 * quarters), size = magnitude(part);
  const LaneMask two = below(splat(0.4), size), odd = below(splat(0.1), size) & ~two;
  const Lane sine = select(odd, c, s), cosine = select(odd, s, c);
  return {select(two | below(part, splat(-0.1)), -sine, sine),
          select(two | below(splat(0.1), part), -cosine, cosine)};
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
