#pragma once
/// Reads long trajectories in JSON quickly: their points are converted directly, without YAML text.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/controllers/messages.hpp"

namespace polyarm::ros_files {

/// Reads a trajectory, or a goal with one, of the given message types. Returns nothing if the trajectory is
/// short, the message is of another kind, or points contain anything but plain numbers: use read_message()
/// then, which also reports mistakes. Throws Error as read_message() does for mistakes outside the points.
std::optional<controllers::Input> read_json_trajectory(const nlohmann::json& message, const std::string& name,
                                                       const std::vector<std::string>& types);

}  // namespace polyarm::ros_files
