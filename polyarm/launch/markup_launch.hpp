#pragma once
/// Launch files of ROS 2 in XML and YAML: their elements are handed on as the actions that Python launch
/// files name. Private to the room.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

/// Knows what the actions of a launch file mean.
class LaunchActions {
 public:
  virtual ~LaunchActions() = default;
  /// "Node", "DeclareLaunchArgument", "Command" and so on, with Python's names of the arguments.
  virtual Value act(const std::string& action, const Arguments& arguments, const Location& where) = 0;
  virtual void not_read(const Location& where, std::string what) = 0;
};

/// Is this text a launch file of ROS 2, in XML or YAML?
bool is_markup_launch(std::string_view text, const std::filesystem::path& path);

/// Reads the elements in order. Throws Error where the text is no XML or YAML. At most 50,000 elements that
/// are nested 32 deep; what lies beyond is not read.
void read_markup_launch(std::string_view text, const std::filesystem::path& path, LaunchActions& actions);

}  // namespace polyarm::ros_files::python
