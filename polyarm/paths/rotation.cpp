#include "polyarm/paths/rotation.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace polyarm::paths {
namespace {

constexpr std::size_t kTerms = 20;  // terms of the series below: exact to the last digit up to two turns

/// (-1)^k / (2k + first)!
constexpr std::array<double, kTerms> series(int first) {
  std::array<double, kTerms> out{};
  double term = 1;
  for (int i = 2; i <= first; ++i) term /= i;
  for (std::size_t k = 0; k < kTerms; ++k) {
    out[k] = term;
    const double n = static_cast<double>(2 * k) + first;
    term /= -(n + 1) * (n + 2);
  }
  return out;
}
constexpr auto kCosine = series(2);  // (1 - cos t)/t² in powers of t²
constexpr auto kSine = series(3);    // (t - sin t)/t³

/// A function of x = phi . phi, and its derivatives with respect to the path parameter.
Jet<double> along(const std::array<double, kTerms>& of_x, const Jet<double>& x) {
  const Jet<double> f = polynomial_at(of_x.data(), kTerms, x.value, 1);
  return {f.value, f.first * x.first, f.second * x.first * x.first + f.first * x.second};
}

/// The right Jacobian's inverse times `v`.
Vec3 unturn(const Vec3& phi, const Vec3& v) {
  const double square = dot(phi, phi), t = std::sqrt(square);
  const double c = t < 1e-2 ? 1.0 / 12 + square / 720 + square * square / 30240
                            : 1 / square - std::cos(t / 2) / (2 * t * std::sin(t / 2));
  const Vec3 once = cross(phi, v);
  return v + 0.5 * once + c * cross(phi, once);
}

}  // namespace

Quaternion exponential(const Vec3& phi) noexcept {
  const double t = norm(phi);
  if (t < 1e-10) return normalized(Quaternion{phi.x / 2, phi.y / 2, phi.z / 2, 1});
  const double s = std::sin(t / 2) / t;
  return {s * phi.x, s * phi.y, s * phi.z, std::cos(t / 2)};
}

BodyRate body_rate(const Jet<Vec3>& phi) noexcept {
  const Vec3 &p = phi.value, &d1 = phi.first, &d2 = phi.second, &d3 = phi.third;
  const Vec3 once = cross(p, d1), once1 = cross(p, d2), once2 = cross(d1, d2) + cross(p, d3);
  const Vec3 twice = cross(p, once), twice1 = cross(d1, once) + cross(p, once1);
  const Vec3 twice2 = cross(d2, once) + 2.0 * cross(d1, once1) + cross(p, once2);
  const Jet<double> x{dot(p, p), 2 * dot(p, d1), 2 * (dot(d1, d1) + dot(p, d2))};
  const Jet<double> a = along(kCosine, x), b = along(kSine, x);
  return {d1 - a.value * once + b.value * twice,
          d2 - a.first * once - a.value * once1 + b.first * twice + b.value * twice1,
          d3 - a.second * once - 2 * a.first * once1 - a.value * once2 + b.second * twice +
              2 * b.first * twice1 + b.value * twice2};
}

Jet<Vec3> rotation_vector(const Quaternion& rotation, const BodyRate& rate) noexcept {
  Jet<Vec3> phi{to_rotation_vector(rotation)};
  phi.first = unturn(phi.value, rate.value);
  phi.second = unturn(phi.value, rate.first - body_rate(phi).first);
  return phi;
}

}  // namespace polyarm::paths
