#include "polyarm/moves/arm_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::moves {
namespace {

std::array<Vec3, 3> columns_of(const Quaternion& r) {
  return {r * Vec3{1, 0, 0}, r * Vec3{0, 1, 0}, r * Vec3{0, 0, 1}};
}
Vec3 times(const std::array<Vec3, 3>& r, const Vec3& v) {
  return v.x * r[0] + v.y * r[1] + v.z * r[2];
}

}  // namespace

ArmDerivatives::ArmDerivatives(const kinematics::Chain& chain) {
  for (std::size_t j = 0; j < chain.joints(); ++j)
    if (chain.moves_tcp(j)) joints_.push_back(j);
  for (const kinematics::Chain::Axis& axis : chain.axes()) {
    const auto found = std::find(joints_.begin(), joints_.end(), axis.joint);
    if (found == joints_.end()) continue;
    axes_.push_back({axis.joint,
                     static_cast<std::size_t>(found - joints_.begin()),
                     axis.slides,
                     axis.ratio,
                     axis.direction,
                     axis.point,
                     {},
                     {}});
  }
  const Pose zero = chain.forward(std::vector<double>(chain.joints(), 0.0));
  position_zero_ = zero.position;
  rotation_zero_ = columns_of(zero.rotation);
  for (auto& J : J_) J.assign(6 * columns(), 0.0);
}

void ArmDerivatives::at(std::span<const double> q) noexcept {
  std::array<Vec3, 3> r{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 t;
  for (Axis& axis : axes_) {  // product of exponentials
    const double value = axis.ratio * q[axis.joint];
    axis.z[0] = times(r, axis.direction);
    axis.o[0] = times(r, axis.point) + t;
    if (axis.slides) {
      t = t + value * axis.z[0];
      continue;
    }
    const double c = std::cos(value), s = std::sin(value);
    for (Vec3& column : r)
      column = c * column + s * cross(axis.z[0], column) + (1 - c) * dot(axis.z[0], column) * axis.z[0];
    t = axis.o[0] - times(r, axis.point);
  }
  position_ = times(r, position_zero_) + t;
  for (std::size_t k = 0; k < 3; ++k) rotation_[k] = times(r, rotation_zero_[k]);
  tcp_[0] = position_;
  fill(0);
}

void ArmDerivatives::move(std::span<const double> first) noexcept {
  Vec3 origin, turn;  // of the body that carries the axis
  for (Axis& axis : axes_) {
    const double rate = axis.ratio * first[axis.column];
    axis.z[1] = cross(turn, axis.z[0]);
    axis.o[1] = origin + cross(turn, axis.o[0]);
    if (axis.slides) {
      origin = origin + rate * axis.z[0];
    } else {
      origin = origin + rate * cross(axis.o[0], axis.z[0]);
      turn = turn + rate * axis.z[0];
    }
  }
  tcp_[1] = origin + cross(turn, tcp_[0]);
  fill(1);
}

void ArmDerivatives::move_on(std::span<const double> first, std::span<const double> second) noexcept {
  Vec3 origin, turn, origin1, turn1;  // and their derivatives
  for (Axis& axis : axes_) {
    const double rate = axis.ratio * first[axis.column], rate1 = axis.ratio * second[axis.column];
    axis.z[2] = cross(turn1, axis.z[0]) + cross(turn, axis.z[1]);
    axis.o[2] = origin1 + cross(turn1, axis.o[0]) + cross(turn, axis.o[1]);
    if (axis.slides) {
      origin = origin + rate * axis.z[0];
      origin1 = origin1 + rate1 * axis.z[0] + rate * axis.z[1];
    } else {
      const Vec3 moment = cross(axis.o[0], axis.z[0]);
      origin = origin + rate * moment;
      origin1 = origin1 + rate1 * moment + rate * (cross(axis.o[1], axis.z[0]) + cross(axis.o[0], axis.z[1]));
      turn = turn + rate * axis.z[0];
      turn1 = turn1 + rate1 * axis.z[0] + rate * axis.z[1];
    }
  }
  tcp_[2] = origin1 + cross(turn1, tcp_[0]) + cross(turn, tcp_[1]);
  fill(2);
}

void ArmDerivatives::fill(std::size_t order) noexcept {
  constexpr double kChoose[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 2, 1}};
  std::fill(J_[order].begin(), J_[order].end(), 0.0);
  for (const Axis& axis : axes_) {
    Vec3 linear = axis.slides ? axis.z[order] : Vec3{};
    if (!axis.slides)
      for (std::size_t k = 0; k <= order; ++k)
        linear = linear + kChoose[order][k] * cross(axis.z[order - k], tcp_[k] - axis.o[k]);
    const Vec3 angular = axis.slides ? Vec3{} : axis.z[order];
    double* column = J_[order].data() + 6 * axis.column;
    const double values[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (std::size_t row = 0; row < 6; ++row) column[row] += axis.ratio * values[row];
  }
}

}  // namespace polyarm::moves
