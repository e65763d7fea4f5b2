#pragma once
/// What the readers of ROS 1 and ROS 2 parameters share. Private to this room. Any thread.
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/controllers_file.hpp"

namespace polyarm::ros_files {

/// PACKAGE/CLASS, or a name with "::".
inline bool is_class_name(const std::string& type) {
  return type.find('/') != std::string::npos || type.find("::") != std::string::npos;
}

inline bool sounds_like_controller(const std::string& name) {
  const std::string plain = lower(name);
  if (plain.starts_with("publish")) return false;  // nodes that send to controllers
  return plain.find("controller") != std::string::npos || plain.find("broadcaster") != std::string::npos;
}

/// Adds an entry. The count is limited, because each entry is compared with each other one. Throws
/// Error("too-many").
inline void add_bounded(std::vector<ControllerEntry>& list, ControllerEntry entry) {
  if (list.size() >= bounds::kFileControllers)
    throw Error(Problem{"too-many", entry.where,
                        "more than " + std::to_string(bounds::kFileControllers) + " controllers are declared",
                        "name only those that the cell uses"});
  list.push_back(std::move(entry));
}

/// Adds the controllers, gains and rates that the parameters of ROS 1 contain to `out`. Mistakes are added to
/// `problems`; throws Error("too-many").
void read_ros1_controllers(const ParameterTree& tree, ControllersFile& out, Problems& problems);

}  // namespace polyarm::ros_files
