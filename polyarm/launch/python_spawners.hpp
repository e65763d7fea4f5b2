#pragma once
/// Finds the controllers that the actions of a launch file start. Private to the room.
#include <string>
#include <vector>

#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

struct Spawned {
  std::vector<std::string> names;  ///< controllers that become active
  std::vector<std::string> files;  ///< --param-file
  bool known = true;               ///< false: some names are computed
};

/// From the `arguments` of controller_manager's spawner node.
Spawned spawned_by_spawner(const Value& arguments);
/// From the `cmd` of ExecuteProcess: `ros2 control load_controller --set-state active NAME`, `ros2 control
/// set_controller_state NAME active`, `ros2 control switch_controllers --activate NAMES` and `ros2 run
/// controller_manager spawner NAMES`. Other commands give nothing.
Spawned spawned_by_command(const Value& cmd);

}  // namespace polyarm::ros_files::python
