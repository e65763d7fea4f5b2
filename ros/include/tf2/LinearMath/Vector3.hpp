#pragma once
#include <cmath>

using tf2Scalar = double;
namespace tf2 {
class Vector3 {
 public:
  Vector3() = default;
  Vector3(double x, double y, double z) : v_{x, y, z} {}
  double x() const { return v_[0]; }
  double y() const { return v_[1]; }
  double z() const { return v_[2]; }
  double getX() const { return v_[0]; }
  double getY() const { return v_[1]; }
  double getZ() const { return v_[2]; }
  void setX(double value) { v_[0] = value; }
  void setY(double value) { v_[1] = value; }
  void setZ(double value) { v_[2] = value; }
  void setValue(double x, double y, double z) { v_[0] = x, v_[1] = y, v_[2] = z; }
  double& operator[](int i) { return v_[i]; }
  const double& operator[](int i) const { return v_[i]; }
  double dot(const Vector3& o) const { return x() * o.x() + y() * o.y() + z() * o.z(); }
  Vector3 cross(const Vector3& o) const {
    return {y() * o.z() - z() * o.y(), z() * o.x() - x() * o.z(), x() * o.y() - y() * o.x()};
  }
  double length2() const { return dot(*this); }
  double length() const { return std::sqrt(length2()); }
  Vector3 normalized() const { return *this * (1 / length()); }
  Vector3& normalize() { return *this = normalized(); }
  Vector3 operator+(const Vector3& o) const { return {x() + o.x(), y() + o.y(), z() + o.z()}; }
  Vector3 operator-(const Vector3& o) const { return {x() - o.x(), y() - o.y(), z() - o.z()}; }
  Vector3 operator-() const { return {-x(), -y(), -z()}; }
  Vector3 operator*(double s) const { return {x() * s, y() * s, z() * s}; }
  Vector3 operator/(double s) const { return *this * (1 / s); }
  Vector3& operator+=(const Vector3& o) { return *this = *this + o; }

 private:
  double v_[3] = {0, 0, 0};
};
inline Vector3 operator*(double s, const Vector3& v) {
  return v * s;
}
}  // namespace tf2
