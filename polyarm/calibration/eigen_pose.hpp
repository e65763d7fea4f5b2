#pragma once
/// Poses as matrices. Private to this room: no header that others include has Eigen types.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "polyarm/calibration/estimate.hpp"

namespace polyarm::calibration {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

inline Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}
inline Vec3 vec3(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
inline Eigen::Matrix3d matrix(const Quaternion& q) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
}
inline Quaternion quaternion(const Eigen::Matrix3d& r) {
  const Eigen::Quaterniond q(r);
  return normalized(Quaternion{q.x(), q.y(), q.z(), q.w()});
}
/// The rotation by the vector `v`.
inline Quaternion turn(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-300) return {};
  return from_axis_angle(vec3(v / angle), angle);
}
inline Eigen::Vector3d rotation_vector(const Quaternion& q) {
  return eigen(to_rotation_vector(q));
}
/// `pose` moved by a small step, in its outer frame: x y z and a rotation vector.
inline Pose moved(const Pose& pose, const Eigen::Ref<const Vector>& step) {
  return {pose.position + vec3(step.head<3>()), normalized(turn(step.segment<3>(3)) * pose.rotation)};
}
inline double largest_sigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(
      std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2]));
}
/// `covariance` is 6 by 6, as PoseEstimate has it.
inline PoseEstimate estimate(const Pose& pose, const Matrix& covariance) {
  PoseEstimate out;
  out.pose = pose;
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j)
      out.covariance[static_cast<std::size_t>(6 * i + j)] = covariance(i, j);
  out.position_sigma = largest_sigma(covariance.topLeftCorner<3, 3>());
  out.rotation_sigma = largest_sigma(covariance.bottomRightCorner<3, 3>());
  return out;
}
/// The rotation R that minimises the sum of |a_i - R b_i|^2 for H = sum a_i b_i^T (Kabsch 1976).
inline Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& H) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  sign.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace polyarm::calibration
