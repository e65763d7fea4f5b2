#pragma once
/// Programs compare numbers without the rounding of floating-point arithmetic. 30deg six times is 180deg, and
/// 300mm / 100mm is 3. Two numbers are equal if they differ by at most 1e-12 of the larger one, or by 1e-12
/// in SI units. Whole numbers are compared exactly. Any thread; allocates nothing. All numbers are finite.
#include <algorithm>
#include <cmath>

namespace polyarm::program {

inline constexpr double kRounding = 1e-12;

inline bool is_whole(double value) {
  return value == std::floor(value);
}

/// The larger of two numbers as a measure of their rounding.
inline double rounding_of(double a, double b) {
  return kRounding * std::max({1.0, std::abs(a), std::abs(b)});
}

inline bool equal_numbers(double a, double b) {
  if (a == b) return true;
  return std::abs(a - b) <= rounding_of(a, b) && !(is_whole(a) && is_whole(b));
}

inline bool less_number(double a, double b) {
  return a < b && !equal_numbers(a, b);
}

/// The whole number that a computed value means, else the value.
inline double unrounded(double value) {
  const double whole = std::round(value);
  return std::abs(whole - value) <= rounding_of(value, 0) ? whole : value;
}

/// The rest of a division by `divisor`: a rest that misses the divisor only by rounding is 0.
inline double unrounded_rest(double rest, double of, double divisor) {
  const double misses = std::min(std::abs(rest), std::abs(divisor) - std::abs(rest));
  constexpr double kOfTheWhole = 1e-15;  // some of its last digits
  const bool rounded = misses <= kRounding * std::abs(divisor) + kOfTheWhole * std::abs(of);
  return rounded && !(is_whole(of) && is_whole(divisor)) ? 0.0 : rest;
}

}  // namespace polyarm::program
