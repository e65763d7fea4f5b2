#include "polyarm/move_group/poses.hpp"

#include <cmath>

namespace polyarm::move_group {

Quaternion rotation_of(const geometry::Quaternion& q, const std::string& what, int code) {
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!std::isfinite(length))
    throw Refusal(code, "the rotation of " + what + " has a number that is not finite");
  if (length < 1e-9) return {};
  if (std::abs(length - 1) > 0.1)
    throw Refusal(code, "the rotation of " + what + " is a quaternion of length " + std::to_string(length) +
                            ", which must be 1");
  return normalized(Quaternion{q.x, q.y, q.z, q.w});
}

Pose pose_of(const geometry::Pose& pose, const std::string& what, int code) {
  const Vec3 at{pose.position.x, pose.position.y, pose.position.z};
  if (!std::isfinite(norm(at)))
    throw Refusal(code, "the position of " + what + " has a number that is not finite");
  return {at, rotation_of(pose.orientation, what, code)};
}

Pose pose_of(const geometry::Transform& transform, const std::string& what, int code) {
  geometry::Pose pose;
  pose.position = {transform.translation.x, transform.translation.y, transform.translation.z};
  pose.orientation = transform.rotation;
  return pose_of(pose, what, code);
}

geometry::Quaternion to_message(const Quaternion& q) {
  return {q.x, q.y, q.z, q.w};
}
geometry::Pose to_message(const Pose& pose) {
  return {{pose.position.x, pose.position.y, pose.position.z}, to_message(pose.rotation)};
}

}  // namespace polyarm::move_group
