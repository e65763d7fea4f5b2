#pragma once
/// Converts ROS messages from YAML or JSON, and output samples to JSON.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/messages.hpp"

namespace polyarm::ros_files {

/// Reads a message of one of `types` ("trajectory_msgs/JointTrajectory", "geometry_msgs/Twist", …); its keys
/// decide which. `name` is used in error messages. Throws Error with the location of the mistake.
controllers::Input read_message(const std::string& text, const std::string& name,
                                const std::vector<std::string>& types);

/// The newest sample as a JSON object in the shape of its ROS message; NaN and infinity become null.
std::string message_json(const controllers::Output& output);

/// The types that read_message understands.
std::vector<std::string> message_types();

}  // namespace polyarm::ros_files
