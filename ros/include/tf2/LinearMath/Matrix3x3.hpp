#pragma once
#include <algorithm>
#include <cmath>

#include "tf2/LinearMath/Quaternion.hpp"

namespace tf2 {
class Matrix3x3 {
 public:
  Matrix3x3() = default;
  explicit Matrix3x3(const Quaternion& q) { setRotation(q); }
  Matrix3x3(double xx, double xy, double xz, double yx, double yy, double yz, double zx, double zy, double zz)
      : rows_{{xx, xy, xz}, {yx, yy, yz}, {zx, zy, zz}} {}
  void setRotation(const Quaternion& raw) {
    const Quaternion q = raw.normalized();
    const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
    rows_[0] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)};
    rows_[1] = {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)};
    rows_[2] = {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)};
  }
  const Vector3& operator[](int i) const { return rows_[i]; }
  Vector3& operator[](int i) { return rows_[i]; }
  Vector3 operator*(const Vector3& v) const { return {rows_[0].dot(v), rows_[1].dot(v), rows_[2].dot(v)}; }
  Matrix3x3 transpose() const {
    Matrix3x3 out;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) out[i][k] = rows_[k][i];
    return out;
  }
  Matrix3x3 operator*(const Matrix3x3& o) const {
    const Matrix3x3 t = o.transpose();
    Matrix3x3 out;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) out[i][k] = rows_[i].dot(t[k]);
    return out;
  }
  void getRPY(double& r, double& p, double& y) const {
    p = std::asin(std::clamp(-rows_[2].x(), -1.0, 1.0));
    r = std::atan2(rows_[2].y(), rows_[2].z());
    y = std::atan2(rows_[1].x(), rows_[0].x());
  }
  void getEulerYPR(double& y, double& p, double& r) const { getRPY(r, p, y); }

 private:
  Vector3 rows_[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};
}  // namespace tf2
