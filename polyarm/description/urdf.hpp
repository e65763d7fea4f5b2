#pragma once
/// Reads and writes URDF. SI units.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::description {

struct UrdfOptions {
  /// Finds the packages of meshes, `package://name/…`; empty: none is found. Meshes are optional.
  PackageSearch packages;
};

/// Reads URDF with its <ros2_control>, <transmission>, <safety_controller> and <gazebo> friction, damping and
/// self-collision. Unusual but valid files are accepted. Throws Error with line and reason if the text cannot
/// be a robot: syntax, several roots, unknown or duplicate names, cycles, values that are not numbers, xacro.
/// `found` gets warnings, and the faults in <ros2_control> as errors: kinematics works without hardware, but
/// code that uses the hardware must refuse if `found.has_errors()`.
RobotModel read_urdf(std::string_view text, const std::string& file, Problems& found,
                     const UrdfOptions& options = {});

/// URDF that reads back equal. Facts that URDF does not have are written in elements that other readers
/// ignore: capsules as <capsule radius length/>, limits of acceleration, deceleration and jerk as attributes
/// of <limit>, and provenance, named states, groups, allowed collisions and estimated inertias in one
/// <polyarm version="1">.
std::string write_urdf(const RobotModel& model);

/// The files that a ROS launch file (XML or Python) mentions, to suggest a command to the user.
struct LaunchHints {
  std::vector<std::string> descriptions;  ///< .urdf and .xacro files
  std::vector<std::string> controllers;   ///< .yaml files
  /// "polyarm run --description … --controllers …", or with another verb.
  std::string line(const std::string& verb = "run") const;
};
bool is_launch_file(const std::filesystem::path& path);
LaunchHints find_in_launch_file(std::string_view text);

}  // namespace polyarm::description
