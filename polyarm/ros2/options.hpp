#pragma once
/// Options to join the ROS 2 graph: from the cell's files, else from the environment. Keys: domain
/// (ROS_DOMAIN_ID), range (ROS_AUTOMATIC_DISCOVERY_RANGE), peers (ROS_STATIC_PEERS), distribution
/// (ROS_DISTRO), namespace, cmd_vel, move_group.
#include <map>
#include <string>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/participant/dds_types.hpp"

namespace polyarm::ros2 {

using Options = std::map<std::string, std::string>;

/// "" if not set.
std::string option_of(const Options& options, const std::string& key);
/// These throw Error("bad-value").
ParticipantOptions participant_options(const Options& options);
messages::Distribution distribution_of(const Options& options);

/// The value of `cmd_vel`: the twist types that are offered before the topic has a publisher. Throws
/// Error("bad-value").
std::vector<std::string> twists_of(const Options& options);

/// The value of `move_group`: true if the cell answers as MoveIt's move_group. Throws Error("bad-value").
bool has_move_group(const Options& options);

}  // namespace polyarm::ros2
