#pragma once
/// Robots that a user adds to the catalogue: descriptions in the user's own folder. Reads and writes the
/// disk.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// $XDG_CONFIG_HOME/polyarm/robots, else ~/.config/polyarm/robots; empty without a home folder.
std::filesystem::path user_robot_folder();

/// Adds all reasons why a robot cannot be added to the catalogue: nothing moves, revolute or prismatic joints
/// without limits, duplicate names of joints or links, a named state of the wrong size.
void check_for_catalogue(const RobotModel& model, Problems& problems);

/// Completes a description: makes mesh paths absolute, and adds a home (all zeros, moved inside the limits)
/// and a source. Adds a note for each.
void complete_for_catalogue(RobotModel& model, const std::filesystem::path& source);

/// Writes `folder/<maker>/<model>.urdf`, which reads back equal. `name` is maker/model in lower-case letters,
/// digits and underscores. `replace` also removes a robot file of this name with its surfaces. Throws
/// Error("bad-name" | "exists" | "no-folder" | "not-removed").
std::filesystem::path store_robot(const RobotModel& model, const std::string& name,
                                  const std::filesystem::path& folder, bool replace);

/// Removes the robot `name` from `folder`, with its SRDF, and the maker's folder if it is then empty. Returns
/// the description's file. Throws Error("bad-name" | "unknown-robot").
std::filesystem::path remove_robot(const std::string& name, const std::filesystem::path& folder);

/// The robots of that folder, as maker/model, by name.
std::vector<std::string> robots_in(const std::filesystem::path& folder);

}  // namespace polyarm::description
