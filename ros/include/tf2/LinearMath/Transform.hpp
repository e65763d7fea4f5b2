#pragma once
#include "tf2/LinearMath/Matrix3x3.hpp"

namespace tf2 {
/// A rotation, then a shift.
class Transform {
 public:
  Transform() = default;
  explicit Transform(const Quaternion& q, const Vector3& origin = {}) : basis_(q), origin_(origin) {}
  explicit Transform(const Matrix3x3& basis, const Vector3& origin = {}) : basis_(basis), origin_(origin) {}
  static const Transform& getIdentity() {
    static const Transform out;
    return out;
  }
  void setIdentity() { *this = Transform(); }
  Matrix3x3& getBasis() { return basis_; }
  const Matrix3x3& getBasis() const { return basis_; }
  Vector3& getOrigin() { return origin_; }
  const Vector3& getOrigin() const { return origin_; }
  Quaternion getRotation() const {
    Quaternion q;
    basis_.getRotation(q);
    return q;
  }
  void setBasis(const Matrix3x3& basis) { basis_ = basis; }
  void setOrigin(const Vector3& origin) { origin_ = origin; }
  void setRotation(const Quaternion& q) { basis_.setRotation(q); }
  Vector3 operator()(const Vector3& v) const { return basis_ * v + origin_; }
  Vector3 operator*(const Vector3& v) const { return (*this)(v); }
  Quaternion operator*(const Quaternion& q) const { return getRotation() * q; }
  Transform operator*(const Transform& o) const { return Transform(basis_ * o.basis_, (*this)(o.origin_)); }
  Transform& operator*=(const Transform& o) { return *this = *this * o; }
  Transform inverse() const {
    const Matrix3x3 back = basis_.transpose();
    return Transform(back, back * -origin_);
  }
  Transform inverseTimes(const Transform& o) const { return inverse() * o; }
  void mult(const Transform& a, const Transform& b) { *this = a * b; }

 private:
  Matrix3x3 basis_;
  Vector3 origin_;
};
}  // namespace tf2
