#pragma once
/// Controllers by the names under which users of ROS know them.
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// A row of the table.
struct ControllerType {
  std::string name;  ///< "joint_trajectory_controller/JointTrajectoryController"
  std::function<std::unique_ptr<Controller>()> make;
  std::string summary;  ///< one sentence, for lists
  /// Parameters that the name implies, where the file says nothing else.
  std::vector<std::pair<const char*, const char*>> implied = {};
};

/// Those of this room, then those that plugins have brought.
const std::vector<ControllerType>& controller_types();
/// Makes the type known; its name must not be known yet. Called before any cell is built.
void register_controller_type(ControllerType type);
/// Null when there is none.
const ControllerType* find_controller_type(const std::string& name);
/// The names, for hints.
std::vector<std::string> controller_type_names();
/// Does the type only tell what it reads, at a rate that ros_control calls `publish_rate`?
bool is_publisher(const std::string& type);
/// Makes the controller and puts what its type's name implies into `parameters`. Throws
/// Error("unknown-controller-type") with the nearest known name.
std::unique_ptr<Controller> make_controller(const std::string& type, Parameters& parameters);

}  // namespace polyarm::controllers
