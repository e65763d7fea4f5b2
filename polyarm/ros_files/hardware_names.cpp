#include "polyarm/ros_files/hardware_names.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::ros_files {

namespace {
struct PluginName {
  std::string package, type;
};
/// "package/Class" or "package::Class", in lower case.
PluginName parts(const std::string& name) {
  const auto at = name.find_first_of("/:");
  if (at == std::string::npos) return {lower(name), ""};
  return {lower(name.substr(0, at)), lower(name.substr(name.find_last_of("/:") + 1))};
}
/// Most names of plugins have "hardware interface" or "system" in common, so likeness of letters says little:
/// one half is the same, or both names begin alike and are about as long.
bool may_be_meant(const std::string& written, const std::string& name) {
  const PluginName a = parts(written), b = parts(name);
  if (a.package == b.package || (!a.type.empty() && a.type == b.type)) return true;
  const std::size_t longer = std::max(written.size(), name.size()),
                    shorter = std::min(written.size(), name.size());
  return longer - shorter <= 3 && a.package.substr(0, 2) == b.package.substr(0, 2);
}
}  // namespace

const std::vector<HardwareAlias>& hardware_aliases() {
  static const std::vector<HardwareAlias> table = {
      {"mock_components/GenericSystem", "mock"},
      {"fake_components/GenericSystem", "mock"},
      {"hardware_interface/GenericSystem", "mock"},
      {"ros2_control_demo_example_7/RobotSystem", "mock", "integrate_velocity"},
      {"ros2_control_demo_hardware/RRBotSystemPositionOnlyHardware", "mock"},
      {"gz_ros2_control/GazeboSimSystem", "mujoco"},
      {"ign_ros2_control/IgnitionSystem", "mujoco"},
      {"gazebo_ros2_control/GazeboSystem", "mujoco"},
      {"gazebo_ros_control/DefaultRobotHWSim", "mujoco"},
      {"mujoco_ros2_control/MujocoSystem", "mujoco"},
      {"mujoco_ros2_control/MujocoSystemInterface", "mujoco"},
      {"jetbot_control/JetBotSystemHardware", "mock", "", "pca9685"},
  };
  return table;
}

HardwareChoice choose_hardware(const std::string& plugin, const std::string& component) {
  const auto available = [](const std::string& driver) { return hardware::driver_available(driver); };
  const std::string simulated = available("mujoco") ? "mujoco" : "mock";
  if (plugin.empty()) return {simulated, "", "", ""};
  if (available(plugin)) return {plugin, "", "", ""};
  for (const HardwareAlias& alias : hardware_aliases())
    if (plugin == alias.plugin) {
      const std::string driver = available(alias.driver) ? alias.driver : "mock";
      const std::string real = available(alias.real) ? alias.real : "";
      return {driver, alias.flag,
              fmt::format("{}: {} is simulated by {}{}", component, plugin,
                          driver == "mujoco" ? "physics (mujoco)" : driver,
                          real.empty() ? "" : ", on the robot itself it is `hardware: " + real + "`"),
              real};
    }
  std::vector<std::string> names = hardware::driver_names();
  for (const HardwareAlias& alias : hardware_aliases()) names.emplace_back(alias.plugin);
  std::erase_if(names, [&](const std::string& name) { return !may_be_meant(plugin, name); });
  return {simulated, "",
          fmt::format("{}: the plugin {} is not installed, replaced by {}{}", component, plugin,
                      simulated == "mujoco" ? "physics (mujoco)" : "mock", did_you_mean(plugin, names)),
          ""};
}

}  // namespace polyarm::ros_files
