#pragma once
/// How the graph of ROS 2 is joined, by what a cell's files say, and what the environment says where they do
/// not. Keys: domain (ROS_DOMAIN_ID), range (ROS_AUTOMATIC_DISCOVERY_RANGE), peers (ROS_STATIC_PEERS),
/// distribution (ROS_DISTRO), namespace, cmd_vel.
#include <map>
#include <string>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/ros2/dds_types.hpp"

namespace polyarm::ros2 {

using Options = std::map<std::string, std::string>;

/// "" where nothing is said.
std::string option_of(const Options& options, const std::string& key);
/// Throw Error("bad-value").
ParticipantOptions participant_options(const Options& options);
messages::Distribution distribution_of(const Options& options);

/// What `cmd_vel` says: the types of twists that are offered before anybody publishes one. Throws
/// Error("bad-value").
std::vector<std::string> twists_of(const Options& options);

}  // namespace polyarm::ros2
