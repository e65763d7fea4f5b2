#pragma once
/// Long trajectories that come as JSON: their points are taken as they are, without the way through text.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/controllers/messages.hpp"

namespace polyarm::ros_files {

/// A trajectory, or a goal around one, of the given message types. Nothing where the message is short, is
/// another one, or has points that are not plain: read_message() reads these, and says what is wrong. Throws
/// Error as read_message() does for what stands beside the points.
std::optional<controllers::Input> read_json_trajectory(const nlohmann::json& message, const std::string& name,
                                                       const std::vector<std::string>& types);

}  // namespace polyarm::ros_files
