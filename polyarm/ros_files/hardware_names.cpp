#include "polyarm/ros_files/hardware_names.hpp"

#include <fmt/format.h>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::ros_files {

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
  return {simulated, "",
          fmt::format("{}: the plugin {} is not installed, replaced by {}{}", component, plugin,
                      simulated == "mujoco" ? "physics (mujoco)" : "mock", did_you_mean(plugin, names)),
          ""};
}

}  // namespace polyarm::ros_files
