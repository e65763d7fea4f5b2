#pragma once
/// A node of ROS 2's graph whose topics and services carry the tags of a link.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::ros2 {

/// Throws Error("bad-link") where a type, a field or a service is none.
std::unique_ptr<signals::LinkPort> make_port(const signals::LinkEntry& entry);

}  // namespace polyarm::ros2
