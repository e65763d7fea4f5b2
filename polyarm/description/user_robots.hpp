#pragma once
/// Robots that a user adds to the catalogue: descriptions in a folder of the user's own.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// $XDG_CONFIG_HOME/polyarm/robots, else ~/.config/polyarm/robots; empty where there is no home.
std::filesystem::path user_robot_folder();

/// What keeps a robot out of the catalogue, all of it: nothing that moves, revolute or prismatic joints
/// without limits, two joints or links of one name, a named state of the wrong size.
void check_for_catalogue(const RobotModel& model, Problems& problems);

/// What a description may lack: meshes by absolute path, a home (all zeros, moved inside the limits) and a
/// source, each noted.
void complete_for_catalogue(RobotModel& model, const std::filesystem::path& source);

/// Writes `folder/<maker>/<model>.urdf`, which reads back equal. `name` is maker/model, small letters, digits
/// and underscores. Throws Error("bad-name" | "exists").
std::filesystem::path store_robot(const RobotModel& model, const std::string& name,
                                  const std::filesystem::path& folder, bool replace);

/// Takes the robot `name` of `folder` away, its SRDF too, and the maker's folder where nothing else is in it.
/// Returns the description's file. Throws Error("bad-name" | "unknown-robot").
std::filesystem::path remove_robot(const std::string& name, const std::filesystem::path& folder);

/// The robots of that folder, as maker/model, by name.
std::vector<std::string> robots_in(const std::filesystem::path& folder);

}  // namespace polyarm::description
