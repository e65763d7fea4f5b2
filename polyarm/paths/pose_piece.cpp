#include "polyarm/paths/pose_piece.hpp"

#include <cmath>
#include <cstddef>

namespace polyarm::paths {
namespace {

Jet<Vec3> position_of(const PoseDerivatives& at) {
  return {at.pose.position, at.linear[0], at.linear[1], {}};
}

Jet<Vec3> vector_of(const PoseDerivatives& at, const Quaternion& middle) {
  const Quaternion back = inverse(at.pose.rotation);
  return rotation_vector(inverse(middle) * at.pose.rotation,
                         {back * at.angular[0], back * at.angular[1], {}});
}

}  // namespace

PoseDerivatives PosePiece::at(double x) const noexcept {
  PoseDerivatives out;
  if (kind == Kind::polynomial) {
    const Jet<Vec3> p = polynomial_at(position.data(), position.size(), x / length, length);
    const Jet<Vec3> phi = polynomial_at(vector.data(), vector.size(), x / length, length);
    const Quaternion r = rotation * exponential(phi.value);
    const BodyRate rate = body_rate(phi);
    out.pose = {p.value, r};
    out.linear = {p.first, p.second, p.third};
    out.angular = {r * rate.value, r * rate.first, r * (rate.second + cross(rate.value, rate.first))};
    return out;
  }
  if (kind == Kind::line) {
    out.pose.position = point + x * across;
    out.linear[0] = across;
  } else {
    const double c = std::cos(x / radius), s = std::sin(x / radius), k = 1 / radius;
    const Vec3 outward = c * across + s * along, forward = c * along - s * across;
    out.pose.position = point + radius * outward;
    out.linear = {forward, -k * outward, -k * k * forward};
  }
  out.pose.rotation = rotation * exponential(x * turn);
  out.angular[0] = rotation * turn;  // rotation about itself: constant along the piece
  return out;
}

PosePiece line_piece(const Pose& from, const Pose& to, double length) noexcept {
  PosePiece out;
  out.length = length;
  out.point = from.position;
  out.across = (1 / length) * (to.position - from.position);
  out.rotation = from.rotation;
  out.turn = (1 / length) * to_rotation_vector(inverse(from.rotation) * to.rotation);
  return out;
}

PosePiece arc_piece(const Pose& from, const Vec3& center, const Vec3& axis, double angle,
                    const Vec3& turn) noexcept {
  PosePiece out;
  out.kind = PosePiece::Kind::arc;
  out.radius = norm(from.position - center);
  out.length = out.radius * std::abs(angle);
  out.point = center;
  out.across = (1 / out.radius) * (from.position - center);
  out.along = cross(angle < 0 ? -axis : axis, out.across);
  out.rotation = from.rotation;
  out.turn = turn;
  return out;
}

PosePiece joining_piece(const PoseDerivatives& from, const PoseDerivatives& to, const Quaternion& middle,
                        double length) noexcept {
  PosePiece out;
  out.kind = PosePiece::Kind::polynomial;
  out.length = length;
  out.rotation = middle;
  out.position = hermite5(position_of(from), position_of(to), length);
  out.vector = hermite5(vector_of(from, middle), vector_of(to, middle), length);
  return out;
}

std::array<Vec3, 6> hull(const std::array<Vec3, 6>& c) noexcept {
  constexpr int kChoose[6][6] = {{1, 0, 0, 0, 0, 0}, {1, 1, 0, 0, 0, 0}, {1, 2, 1, 0, 0, 0},
                                 {1, 3, 3, 1, 0, 0}, {1, 4, 6, 4, 1, 0}, {1, 5, 10, 10, 5, 1}};
  std::array<Vec3, 6> out;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k <= i; ++k)
      out[i] = out[i] + static_cast<double>(kChoose[i][k]) / kChoose[5][k] * c[k];
  return out;
}

}  // namespace polyarm::paths
