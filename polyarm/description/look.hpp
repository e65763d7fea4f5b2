#pragma once
/// The file beside a robot file that has the robot's measured surfaces.

namespace polyarm::description {

/// The key of RobotModel::look with the path of MODEL.look. Only the reader of robot files sets it: a robot
/// file cannot name another file.
inline constexpr const char* kMeasuredLook = "measured";

}  // namespace polyarm::description
