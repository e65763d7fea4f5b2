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
  Vector3& operator-=(const Vector3& o) { return *this = *this - o; }
  Vector3& operator*=(double s) { return *this = *this * s; }
  Vector3& operator/=(double s) { return *this = *this / s; }
  bool operator==(const Vector3& o) const { return x() == o.x() && y() == o.y() && z() == o.z(); }
  bool operator!=(const Vector3& o) const { return !(*this == o); }
  void setZero() { setValue(0, 0, 0); }
  double distance2(const Vector3& o) const { return (o - *this).length2(); }
  double distance(const Vector3& o) const { return (o - *this).length(); }
  double angle(const Vector3& o) const { return std::acos(dot(o) / std::sqrt(length2() * o.length2())); }
  Vector3 lerp(const Vector3& o, double t) const { return *this + (o - *this) * t; }
  Vector3 rotate(const Vector3& axis, double angle) const {
    const Vector3 along = axis * axis.dot(*this), across = *this - along;
    return along + across * std::cos(angle) + axis.cross(*this) * std::sin(angle);
  }

 private:
  double v_[3] = {0, 0, 0};
};
inline double tf2Dot(const Vector3& a, const Vector3& b) {
  return a.dot(b);
}
inline Vector3 tf2Cross(const Vector3& a, const Vector3& b) {
  return a.cross(b);
}
inline double tf2Distance(const Vector3& a, const Vector3& b) {
  return a.distance(b);
}
inline Vector3 operator*(double s, const Vector3& v) {
  return v * s;
}
}  // namespace tf2
