#pragma once
#include <cmath>

#include "tf2/LinearMath/Vector3.hpp"

namespace tf2 {
class Quaternion {
 public:
  Quaternion() = default;
  Quaternion(double x, double y, double z, double w) : x_(x), y_(y), z_(z), w_(w) {}
  Quaternion(const Vector3& axis, double angle) { setRotation(axis, angle); }
  static Quaternion getIdentity() { return {0, 0, 0, 1}; }
  void setValue(double x, double y, double z, double w) { x_ = x, y_ = y, z_ = z, w_ = w; }
  void setRotation(const Vector3& axis, double angle) {
    const Vector3 v = axis.normalized() * std::sin(angle / 2);
    setValue(v.x(), v.y(), v.z(), std::cos(angle / 2));
  }
  void setRPY(double r, double p, double y) {
    const double cr = std::cos(r / 2), sr = std::sin(r / 2), cp = std::cos(p / 2), sp = std::sin(p / 2);
    const double cy = std::cos(y / 2), sy = std::sin(y / 2);
    setValue(sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy,
             cr * cp * cy + sr * sp * sy);
  }
  double x() const { return x_; }
  double y() const { return y_; }
  double z() const { return z_; }
  double w() const { return w_; }
  double getX() const { return x_; }
  double getY() const { return y_; }
  double getZ() const { return z_; }
  double getW() const { return w_; }
  double length2() const { return x_ * x_ + y_ * y_ + z_ * z_ + w_ * w_; }
  double length() const { return std::sqrt(length2()); }
  Quaternion normalized() const {
    const double n = 1 / length();
    return {x_ * n, y_ * n, z_ * n, w_ * n};
  }
  Quaternion& normalize() { return *this = normalized(); }
  Quaternion inverse() const { return {-x_, -y_, -z_, w_}; }
  Quaternion operator*(const Quaternion& o) const {
    return {w_ * o.x_ + x_ * o.w_ + y_ * o.z_ - z_ * o.y_, w_ * o.y_ - x_ * o.z_ + y_ * o.w_ + z_ * o.x_,
            w_ * o.z_ + x_ * o.y_ - y_ * o.x_ + z_ * o.w_, w_ * o.w_ - x_ * o.x_ - y_ * o.y_ - z_ * o.z_};
  }
  Quaternion& operator*=(const Quaternion& o) { return *this = *this * o; }
  Quaternion operator+(const Quaternion& o) const { return {x_ + o.x_, y_ + o.y_, z_ + o.z_, w_ + o.w_}; }
  Quaternion operator-(const Quaternion& o) const { return {x_ - o.x_, y_ - o.y_, z_ - o.z_, w_ - o.w_}; }
  Quaternion operator-() const { return {-x_, -y_, -z_, -w_}; }
  Quaternion operator*(double s) const { return {x_ * s, y_ * s, z_ * s, w_ * s}; }
  Quaternion operator/(double s) const { return *this * (1 / s); }
  bool operator==(const Quaternion& o) const { return x_ == o.x_ && y_ == o.y_ && z_ == o.z_ && w_ == o.w_; }
  bool operator!=(const Quaternion& o) const { return !(*this == o); }
  void setX(double value) { x_ = value; }
  void setY(double value) { y_ = value; }
  void setZ(double value) { z_ = value; }
  void setW(double value) { w_ = value; }
  double dot(const Quaternion& o) const { return x_ * o.x_ + y_ * o.y_ + z_ * o.z_ + w_ * o.w_; }
  double getAngle() const { return 2 * std::acos(std::fmax(-1, std::fmin(1, w_))); }
  double getAngleShortestPath() const { return 2 * std::acos(std::fmin(1, std::fabs(w_))); }
  double angle(const Quaternion& o) const { return std::acos(dot(o) / std::sqrt(length2() * o.length2())); }
  double angleShortestPath(const Quaternion& o) const {
    return 2 * std::acos(std::fmin(1, std::fabs(dot(o)) / std::sqrt(length2() * o.length2())));
  }
  Vector3 getAxis() const {
    const double s = std::sqrt(std::fmax(0, 1 - w_ * w_));
    return s < 1e-12 ? Vector3(1, 0, 0) : Vector3(x_ / s, y_ / s, z_ / s);
  }
  Quaternion slerp(const Quaternion& o, double t) const {
    const double d = dot(o), half = std::acos(std::fmin(1, std::fabs(d)));
    if (half < 1e-9) return *this;
    const Quaternion to = d < 0 ? -o : o;
    return (*this * std::sin((1 - t) * half) + to * std::sin(t * half)) / std::sin(half);
  }

 private:
  double x_ = 0, y_ = 0, z_ = 0, w_ = 1;
};
inline Vector3 quatRotate(const Quaternion& q, const Vector3& v) {
  const Vector3 u(q.x(), q.y(), q.z());
  return v + (u.cross(v) * q.w() + u.cross(u.cross(v))) * 2;
}
}  // namespace tf2
