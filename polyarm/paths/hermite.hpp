#pragma once
/// Polynomials through values and derivatives at both ends, as coefficients of powers of the fraction tau in
/// [0, 1] of a piece. Any thread; no allocation.
#include <array>
#include <cstddef>

namespace polyarm::paths {

/// A value and its derivatives with respect to the path parameter.
template <typename T>
struct Jet {
  T value{}, first{}, second{}, third{};
};

/// Degree 5: value, first and second derivative at both ends of a piece of length `length`.
template <typename T>
constexpr std::array<T, 6> hermite5(const Jet<T>& a, const Jet<T>& b, double length) {
  const T v0 = length * a.first, v1 = length * b.first, d = b.value - a.value;
  const T a0 = 0.5 * length * length * a.second, a1 = 0.5 * length * length * b.second;
  return {a.value,
          v0,
          a0,
          10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1,
          -15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1,
          6.0 * d - 3.0 * v0 - 3.0 * v1 - a0 + a1};
}

/// Degree 7: also the third derivative at both ends.
template <typename T>
constexpr std::array<T, 8> hermite7(const Jet<T>& a, const Jet<T>& b, double length) {
  const double square = length * length, cube = square * length;
  const T v0 = length * a.first, v1 = length * b.first, d = b.value - a.value;
  const T a0 = 0.5 * square * a.second, a1 = 0.5 * square * b.second;
  const T j0 = cube / 6 * a.third, j1 = cube / 6 * b.third;
  return {a.value,
          v0,
          a0,
          j0,
          35.0 * d - 20.0 * v0 - 15.0 * v1 - 10.0 * a0 + 5.0 * a1 - 4.0 * j0 - j1,
          -84.0 * d + 45.0 * v0 + 39.0 * v1 + 20.0 * a0 - 14.0 * a1 + 6.0 * j0 + 3.0 * j1,
          70.0 * d - 36.0 * v0 - 34.0 * v1 - 15.0 * a0 + 13.0 * a1 - 4.0 * j0 - 3.0 * j1,
          -20.0 * d + 10.0 * v0 + 10.0 * v1 + 4.0 * a0 - 4.0 * a1 + j0 + j1};
}

/// The polynomial of `coefficients` and its derivatives at the fraction `tau` of a piece of length `length`.
template <typename T>
constexpr Jet<T> polynomial_at(const T* coefficients, std::size_t count, double tau, double length) {
  T p = coefficients[count - 1], d1{}, d2{}, d3{};
  for (std::size_t k = count - 1; k-- > 0;) {
    d3 = tau * d3 + d2;
    d2 = tau * d2 + d1;
    d1 = tau * d1 + p;
    p = tau * p + coefficients[k];
  }
  const double per = 1 / length;
  return {p, per * d1, 2 * per * per * d2, 6 * per * per * per * d3};
}

}  // namespace polyarm::paths
