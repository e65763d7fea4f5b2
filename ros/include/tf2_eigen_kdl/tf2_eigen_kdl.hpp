#pragma once
/// Between KDL's and Eigen's types. Both libraries are the system's.
#include <Eigen/Geometry>
#include <kdl/frames.hpp>

namespace tf2 {

inline void quaternionKDLToEigen(const KDL::Rotation& from, Eigen::Quaterniond& to) {
  from.GetQuaternion(to.x(), to.y(), to.z(), to.w());
}
inline void quaternionEigenToKDL(const Eigen::Quaterniond& from, KDL::Rotation& to) {
  to = KDL::Rotation::Quaternion(from.x(), from.y(), from.z(), from.w());
}
inline void vectorKDLToEigen(const KDL::Vector& from, Eigen::Matrix<double, 3, 1>& to) {
  to << from.x(), from.y(), from.z();
}
inline void vectorEigenToKDL(const Eigen::Matrix<double, 3, 1>& from, KDL::Vector& to) {
  to = KDL::Vector(from.x(), from.y(), from.z());
}
template <int Mode>
void transformKDLToEigen(const KDL::Frame& from, Eigen::Transform<double, 3, Mode>& to) {
  to.setIdentity();
  for (int i = 0; i < 3; ++i) {
    to.matrix()(i, 3) = from.p(i);
    for (int k = 0; k < 3; ++k) to.matrix()(i, k) = from.M(i, k);
  }
}
template <int Mode>
void transformEigenToKDL(const Eigen::Transform<double, 3, Mode>& from, KDL::Frame& to) {
  for (int i = 0; i < 3; ++i) {
    to.p(i) = from.matrix()(i, 3);
    for (int k = 0; k < 3; ++k) to.M(i, k) = from.matrix()(i, k);
  }
}
inline void twistKDLToEigen(const KDL::Twist& from, Eigen::Matrix<double, 6, 1>& to) {
  for (int i = 0; i < 6; ++i) to[i] = from[i];
}
inline void twistEigenToKDL(const Eigen::Matrix<double, 6, 1>& from, KDL::Twist& to) {
  for (int i = 0; i < 6; ++i) to[i] = from[i];
}
inline void wrenchKDLToEigen(const KDL::Wrench& from, Eigen::Matrix<double, 6, 1>& to) {
  for (int i = 0; i < 6; ++i) to[i] = from[i];
}
inline void wrenchEigenToKDL(const Eigen::Matrix<double, 6, 1>& from, KDL::Wrench& to) {
  for (int i = 0; i < 6; ++i) to[i] = from[i];
}

}  // namespace tf2
