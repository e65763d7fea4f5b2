#pragma once
/// What of a plugin's nodes leads nowhere: parameters of other nodes, actions that wires.hpp does not connect,
/// and messages that were not made from a definition. The first use of each name is logged.
#include <mutex>
#include <set>
#include <string>

#include "polyarm_ros/log.hpp"

namespace polyarm_ros {

inline void report_unavailable(const std::string& node, const char* what, const std::string& name) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (!said.insert(what + name).second) return;
  if (std::string(what) == "node")
    log_format(Severity::warn, node.c_str(), "the parameters of the node '%s' are not known here",
               name.c_str());
  else
    log_format(Severity::warn, node.c_str(), "the %s '%s' leads %s: it is not on the ROS 2 graph", what,
               name.c_str(), std::string(what) == "topic" ? "no further than this module" : "nowhere");
}

}  // namespace polyarm_ros
