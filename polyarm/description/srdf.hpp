#pragma once
/// SRDF, the file that MoveIt keeps beside a description: groups, named states, end effectors, allowed
/// collisions. SI units.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/self_collision.hpp"

namespace polyarm::description {

/// Adds the content of the SRDF to the model: groups (joints, links, chains, subgroups), end effectors, pairs
/// with disabled collisions, and group states as named states. A state with only some of the joints takes the
/// others from an existing state of the same name, else from "home", else zero (or the limit nearest to
/// zero). Unknown joints, links and groups in groups and states are errors; unknown links in
/// disable_collisions are warnings; both name the nearest known name. Throws Error if the text is not SRDF;
/// faults inside are skipped and added to `problems`.
void read_srdf(std::string_view text, const std::string& file, RobotModel& model, Problems& problems);

/// The model's groups, their named states, end effectors and `pairs` as SRDF that reads back equal. A group
/// of consecutive links is written as a chain, any other as its joints. The root is attached to `world`
/// unless the description itself attaches it (`hung` false).
std::string write_srdf(const RobotModel& model, const std::vector<LinkPair>& pairs, bool hung = true);

/// The path of a description's SRDF: `arm.srdf` beside arm.urdf, arm.xacro or arm.urdf.xacro.
std::filesystem::path srdf_beside(const std::filesystem::path& description);

}  // namespace polyarm::description
