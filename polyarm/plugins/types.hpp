#pragma once
/// Table of controller types, by the names that ROS uses.
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// An entry of the table.
struct ControllerType {
  std::string name;  ///< "joint_trajectory_controller/JointTrajectoryController"
  std::function<std::unique_ptr<Controller>()> make;
  std::string summary;  ///< one sentence, for lists
  /// Parameters that the name implies, unless the file sets them.
  std::vector<std::pair<const char*, const char*>> implied = {};
};

/// The built-in types, then those of plugins.
const std::vector<ControllerType>& controller_types();
/// Adds a type; its name must not exist yet. Call before any cell is built.
void register_controller_type(ControllerType type);
/// Null if there is no such type.
const ControllerType* find_controller_type(const std::string& name);
/// All type names, for hints in error messages.
std::vector<std::string> controller_type_names();
/// True if the type only publishes what it reads, at a rate that ros_control calls `publish_rate`.
bool is_publisher(const std::string& type);
/// Creates the controller and adds the parameters that its type's name implies to `parameters`. Throws
/// Error("unknown-controller-type") with the nearest known name.
std::unique_ptr<Controller> make_controller(const std::string& type, Parameters& parameters);

}  // namespace polyarm::controllers
