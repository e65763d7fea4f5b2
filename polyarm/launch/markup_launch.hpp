#pragma once
/// Reads ROS 2 launch files in XML and YAML. Each element is passed on as the action that Python launch files
/// name. Private to the room.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

/// Receives the actions of a launch file.
class LaunchActions {
 public:
  virtual ~LaunchActions() = default;
  /// "Node", "DeclareLaunchArgument", "Command" and so on, with the Python names of the arguments.
  virtual Value act(const std::string& action, const Arguments& arguments, const Location& where) = 0;
  virtual void not_read(const Location& where, std::string what) = 0;
};

/// True if the text is a ROS 2 launch file in XML or YAML.
bool is_markup_launch(std::string_view text, const std::filesystem::path& path);

/// Reads the elements in order. Throws Error if the text is not valid XML or YAML. Reads at most 50,000
/// elements, nested up to 32 deep, and ignores the rest.
void read_markup_launch(std::string_view text, const std::filesystem::path& path, LaunchActions& actions);

}  // namespace polyarm::ros_files::python
