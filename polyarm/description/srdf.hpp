#pragma once
/// SRDF, what MoveIt keeps beside a description: groups, named states, end effectors, allowed collisions.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/self_collision.hpp"

namespace polyarm::description {

/// Adds what the SRDF says to the model: groups (joints, links, chains, groups within groups), end effectors,
/// pairs whose collisions are disabled, and group states as named states. A state that names only some of the
/// joints takes the rest from the state of its name that is there, else from "home", else zero (or the limit
/// nearest to it). Unknown joints, links and groups in groups and states are errors, links in
/// disable_collisions that the robot lacks are warnings; with the nearest name. Throws Error for what is no
/// SRDF; what is wrong within is passed over and added to `problems`.
void read_srdf(std::string_view text, const std::string& file, RobotModel& model, Problems& problems);

/// The model's groups, their named states, end effectors and `pairs` as SRDF, which reads back equal. A group
/// whose links hang one below the other is written as a chain, any other as its joints. The root hangs on
/// `world` unless the description itself says where (`hung` false).
std::string write_srdf(const RobotModel& model, const std::vector<LinkPair>& pairs, bool hung = true);

/// Where the SRDF of a description would be: `arm.srdf` beside arm.urdf, arm.xacro or arm.urdf.xacro.
std::filesystem::path srdf_beside(const std::filesystem::path& description);

}  // namespace polyarm::description
