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
  Matrix3x3& operator*=(const Matrix3x3& o) { return *this = *this * o; }
  void setValue(double xx, double xy, double xz, double yx, double yy, double yz, double zx, double zy, double zz) {
    *this = {xx, xy, xz, yx, yy, yz, zx, zy, zz};
  }
  void setIdentity() { *this = Matrix3x3(); }
  static const Matrix3x3& getIdentity() {
    static const Matrix3x3 out;
    return out;
  }
  const Vector3& getRow(int i) const { return rows_[i]; }
  Vector3 getColumn(int i) const { return {rows_[0][i], rows_[1][i], rows_[2][i]}; }
  double determinant() const { return rows_[0].dot(rows_[1].cross(rows_[2])); }
  Matrix3x3 inverse() const {
    const double s = 1 / determinant();
    const Vector3 a = rows_[1].cross(rows_[2]) * s, b = rows_[2].cross(rows_[0]) * s, c = rows_[0].cross(rows_[1]) * s;
    return {a.x(), b.x(), c.x(), a.y(), b.y(), c.y(), a.z(), b.z(), c.z()};
  }
  void setRPY(double r, double p, double y) {
    Quaternion q;
    q.setRPY(r, p, y);
    setRotation(q);
  }
  void setEulerYPR(double y, double p, double r) { setRPY(r, p, y); }
  void getRotation(Quaternion& q) const {
    const double trace = rows_[0].x() + rows_[1].y() + rows_[2].z();
    double v[4];
    if (trace > 0) {
      double s = std::sqrt(trace + 1);
      v[3] = s / 2, s = 0.5 / s;
      v[0] = (rows_[2].y() - rows_[1].z()) * s, v[1] = (rows_[0].z() - rows_[2].x()) * s;
      v[2] = (rows_[1].x() - rows_[0].y()) * s;
    } else {
      const int i = rows_[0].x() < rows_[1].y() ? (rows_[1].y() < rows_[2].z() ? 2 : 1)
                                                : (rows_[0].x() < rows_[2].z() ? 2 : 0);
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      double s = std::sqrt(rows_[i][i] - rows_[j][j] - rows_[k][k] + 1);
      v[i] = s / 2, s = 0.5 / s;
      v[3] = (rows_[k][j] - rows_[j][k]) * s, v[j] = (rows_[j][i] + rows_[i][j]) * s;
      v[k] = (rows_[k][i] + rows_[i][k]) * s;
    }
    q.setValue(v[0], v[1], v[2], v[3]);
  }
  void getEulerYPR(double& y, double& p, double& r) const { getRPY(r, p, y); }

 private:
  Vector3 rows_[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};
}  // namespace tf2
