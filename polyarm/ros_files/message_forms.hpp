#pragma once
/// Messages as users of ROS write them, in YAML or JSON, and as they are shown to them.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/messages.hpp"

namespace polyarm::ros_files {

/// Reads a message of one of `types` ("trajectory_msgs/JointTrajectory", "geometry_msgs/Twist", …); which of
/// them it is follows from its keys. `name` is told in complaints. Throws Error with the place of what is
/// wrong.
controllers::Input read_message(const std::string& text, const std::string& name,
                                const std::vector<std::string>& types);

/// The newest sample as one JSON object in the shape of its ROS message; no number becomes null.
std::string message_json(const controllers::Output& output);

/// The types that read_message understands.
std::vector<std::string> message_types();

}  // namespace polyarm::ros_files
