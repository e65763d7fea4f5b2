#include "polyarm/simd/rotation.hpp"

#include <cmath>

namespace polyarm::kinematics {

Rotation rotation_of(const Quaternion& q) {
  const auto& [x, y, z, w] = q;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

Rotation rotation_about(const Vec3& h, double angle) {
  const double s = std::sin(angle), c = std::cos(angle), v = 1 - c;
  return {{c + v * h.x * h.x, v * h.x * h.y + s * h.z, v * h.x * h.z - s * h.y},
          {v * h.x * h.y - s * h.z, c + v * h.y * h.y, v * h.y * h.z + s * h.x},
          {v * h.x * h.z + s * h.y, v * h.y * h.z - s * h.x, c + v * h.z * h.z}};
}

}  // namespace polyarm::kinematics
