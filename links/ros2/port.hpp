#pragma once
/// Connects the tags of a link to topics and services through a ROS 2 node.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::ros2 {

/// Throws Error("bad-link") if a type, a field or a service is unknown.
std::unique_ptr<signals::LinkPort> make_port(const signals::LinkEntry& entry);

}  // namespace polyarm::ros2
