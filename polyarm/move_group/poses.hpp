#pragma once
/// Poses of ROS messages. Metres; throws Refusal for numbers that are not finite and rotations without a
/// length.
#include <string>

#include "polyarm/base/pose.hpp"
#include "polyarm/move_group/refusal.hpp"

namespace polyarm::move_group {

namespace geometry = messages::geometry_msgs::msg;

/// `what`: names the pose in the refusal. A rotation of zero counts as none, as in MoveIt.
Pose pose_of(const geometry::Pose& pose, const std::string& what, int code);
Pose pose_of(const geometry::Transform& transform, const std::string& what, int code);
Quaternion rotation_of(const geometry::Quaternion& rotation, const std::string& what, int code);
geometry::Pose to_message(const Pose& pose);
geometry::Quaternion to_message(const Quaternion& rotation);

}  // namespace polyarm::move_group
