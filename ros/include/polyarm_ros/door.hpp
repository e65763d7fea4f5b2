#pragma once
/// Services and actions of a plugin lead nowhere, and its topics only to nodes of the same module, except those of
/// controllers that wires.hpp connects.
/// The first use of each name is logged once.
#include <mutex>
#include <set>
#include <string>

#include "polyarm_ros/log.hpp"

namespace polyarm_ros {

inline void report_unavailable(const std::string& node, const char* what, const std::string& name) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.insert(what + name).second)
    log_format(Severity::warn, node.c_str(), "the %s '%s' leads %s: plugins are not on the ROS 2 graph", what,
               name.c_str(), std::string(what) == "topic" ? "no further than this module" : "nowhere");
}

}  // namespace polyarm_ros
