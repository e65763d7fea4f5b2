#pragma once
/// The joints of an arm for a pose near a known state. Any thread; nothing here allocates.
#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <optional>

#include "drivers/wire/shaper.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::forward {

using wire::Six;

/// `jacobian(q, J)` returns the pose at q and fills J, 6 x 6 by rows: rates of position, then of rotation.
/// Damped least squares; nothing if no state within reach of the seed has the pose.
template <typename Jacobian>
std::optional<Six> near_joints(const Jacobian& jacobian, const Pose& target, Six q) {
  constexpr double kDamping = 1e-8, kMostStep = 0.3, kClose = 1e-8;
  constexpr int kRounds = 40;
  std::array<double, 36> J;
  for (int round = 0; round < kRounds; ++round) {
    const Pose now = jacobian(q, J);
    const Vec3 way = target.position - now.position;
    const Vec3 turn = to_rotation_vector(target.rotation * inverse(now.rotation));
    Eigen::Matrix<double, 6, 1> error;
    error << way.x, way.y, way.z, turn.x, turn.y, turn.z;
    if (error.norm() < kClose) return q;
    const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(J.data());
    const Eigen::Matrix<double, 6, 6> square =
        matrix.transpose() * matrix + kDamping * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> step = square.ldlt().solve(matrix.transpose() * error);
    if (const double size = step.norm(); size > kMostStep) step *= kMostStep / size;
    for (std::size_t i = 0; i < 6; ++i) q[i] += step[static_cast<Eigen::Index>(i)];
  }
  return std::nullopt;
}

}  // namespace polyarm::forward
