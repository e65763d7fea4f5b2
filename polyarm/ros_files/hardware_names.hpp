#pragma once
/// Maps the hardware plugins that descriptions name to drivers of Polyarm.
#include <string>
#include <vector>

namespace polyarm::ros_files {

/// Chooses the driver for a hardware plugin that a description names.
struct HardwareChoice {
  std::string driver;  ///< "mock", "mujoco", …
  std::string flag;    ///< driver parameter that makes it behave like the plugin; empty: none
  std::string note;    ///< one sentence if the plugin was replaced, else empty
  std::string real;    ///< driver of the real robot, if the chosen driver only simulates it
};

/// The driver for a plugin name: a driver of the same name; else that of the alias table of names that ROS
/// users have (mock if that driver is not installed); else physics if installed, and mock if not. An empty
/// name means that no plugin was declared.
HardwareChoice choose_hardware(const std::string& plugin, const std::string& component);

/// A row of the alias table, also shown in the reference.
struct HardwareAlias {
  const char* plugin;
  const char* driver;
  const char* flag = "";
  const char* real = "";
};
const std::vector<HardwareAlias>& hardware_aliases();

}  // namespace polyarm::ros_files
