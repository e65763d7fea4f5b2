#pragma once
/// URDF, read and written.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

struct UrdfOptions {
  /// Folders that hold ROS packages, for `package://name/…`. Meshes are never required.
  std::vector<std::filesystem::path> package_folders;
};

/// Reads URDF with its <ros2_control>, <transmission>, <safety_controller> and <gazebo> friction, damping and
/// self-collision. Odd but legal files are accepted. Throws Error with line and reason for what cannot be a
/// robot: syntax, several roots, unknown or duplicated names, circles, values that are not numbers, xacro.
/// `found` gets warnings, and as errors the faults in <ros2_control>: kinematics does without hardware; code
/// that uses the hardware has to refuse on `found.has_errors()`.
RobotModel read_urdf(std::string_view text, const std::string& file, Problems& found,
                     const UrdfOptions& options = {});

/// URDF that reads back equal. What URDF does not have is written in elements that other readers pass over:
/// capsules as <capsule radius length/>, limits of acceleration, deceleration and jerk as attributes of
/// <limit>, and provenance, named states, groups, allowed collisions and estimated inertias in one
/// <polyarm version="1">.
std::string write_urdf(const RobotModel& model);

/// What a ROS launch file (XML or Python) mentions, so that a user can be told what to type instead.
struct LaunchHints {
  std::vector<std::string> descriptions;  ///< .urdf and .xacro files
  std::vector<std::string> controllers;   ///< .yaml files
  /// "polyarm run --description … --controllers …", or with another verb.
  std::string line(const std::string& verb = "run") const;
};
bool is_launch_file(const std::filesystem::path& path);
LaunchHints find_in_launch_file(std::string_view text);

}  // namespace polyarm::description
