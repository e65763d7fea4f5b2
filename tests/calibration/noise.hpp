#pragma once
/// Random poses and noise with a fixed seed, the same on every machine.
#include <cmath>
#include <cstdint>
#include <random>

#include "polyarm/base/pose.hpp"

namespace polyarm::calibration {

class Noise {
 public:
  explicit Noise(std::uint64_t seed) : draw_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(draw_() >> 11) * 0x1p-53;
  }
  double normal(double sigma) {
    return sigma * std::sqrt(-2 * std::log(1 - uniform(0, 1))) * std::cos(2 * M_PI * uniform(0, 1));
  }
  Vec3 vector(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }
  Vec3 within(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Quaternion turn(const Vec3& v) {
    return norm(v) > 0 ? from_axis_angle(normalized(v), norm(v)) : Quaternion{};
  }
  Quaternion any_rotation() { return normalized(Quaternion{normal(1), normal(1), normal(1), normal(1)}); }
  Pose any_pose(double size) { return {within(size), any_rotation()}; }
  /// `pose` with errors of one standard deviation for each axis, m and rad.
  Pose measured(const Pose& pose, double position, double rotation) {
    return {pose.position + vector(position), normalized(turn(vector(rotation)) * pose.rotation)};
  }

 private:
  std::mt19937_64 draw_;
};

}  // namespace polyarm::calibration
