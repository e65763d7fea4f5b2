#pragma once
#include <string>
#include <vector>

namespace polyarm::ros_files {

/// What stands in for a hardware plugin that a description names.
struct HardwareChoice {
  std::string driver;  ///< "mock", "mujoco", …
  std::string flag;    ///< parameter that makes the driver behave like the plugin; empty: none
  std::string note;    ///< one sentence when something was replaced, else empty
  std::string real;    ///< the driver of the robot itself, where there is one beside what plays it
};

/// The driver for a plugin name of a description: the table of the names that ROS users have, a driver of
/// that very name, else physics where it is installed and mock where it is not. Empty names mean no plugin
/// was declared.
HardwareChoice choose_hardware(const std::string& plugin, const std::string& component);

/// A row of the alias table, for the reference page.
struct HardwareAlias {
  const char* plugin;
  const char* driver;
  const char* flag = "";
  const char* real = "";
};
const std::vector<HardwareAlias>& hardware_aliases();

}  // namespace polyarm::ros_files
