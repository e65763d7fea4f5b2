#pragma once
/// Rotation matrices as plain numbers, for vector code. Radians. Any thread; nothing here allocates.
#include "polyarm/base/pose.hpp"

namespace polyarm::kinematics {

/// A rotation matrix, stored by columns.
struct Rotation {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  friend constexpr Vec3 operator*(const Rotation& r, const Vec3& v) {
    return {r.x.x * v.x + r.y.x * v.y + r.z.x * v.z, r.x.y * v.x + r.y.y * v.y + r.z.y * v.z,
            r.x.z * v.x + r.y.z * v.y + r.z.z * v.z};
  }
  friend constexpr Rotation operator*(const Rotation& a, const Rotation& b) {
    return {a * b.x, a * b.y, a * b.z};
  }
  friend constexpr Rotation transposed(const Rotation& r) {
    return {{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}};
  }
};
Rotation rotation_of(const Quaternion& unit);
/// Rotation by `angle` about a unit axis (Rodrigues' formula).
Rotation rotation_about(const Vec3& unit_axis, double angle);

}  // namespace polyarm::kinematics
