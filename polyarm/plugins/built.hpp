#pragma once
/// Plugins that `polyarm plugin build` made on this machine, in `~/.local/share/polyarm/plugins`
/// (XDG_DATA_HOME): a module NAME.so, and NAME.plugin, a line for each of its classes. A module is opened
/// when one of its classes is made, and only if its content is approved. Building thread only.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/hardware/plugin.hpp"

namespace polyarm::plugins {

struct BuiltClass {
  std::string name;  ///< as a description or a controllers file has it
  std::filesystem::path module;
  std::string help;
  hardware::PluginKind kind = hardware::PluginKind::hardware;
};

/// Empty if there is no home.
std::filesystem::path built_folder();
/// Writes NAME.plugin beside the module, and approves the module's content in place of what was approved
/// before. Throws Error("unwritable").
void record_built(const std::filesystem::path& module, const std::vector<BuiltClass>& classes);
/// The recorded classes whose module exists, in order of modules.
std::vector<BuiltClass> built_classes();
/// A built controller is also known under this and its name, so that a file can say that it means the built one
/// where Polyarm has its own: "ros:joint_trajectory_controller/JointTrajectoryController".
inline constexpr const char* kBuiltPrefix = "ros:";
/// Makes all of them known by name, except where the name is known already. Opens none.
void register_built();
/// True if the name is that of a class which register_built() made known. Such hardware knows its own
/// transmissions.
bool is_built(const std::string& name);
/// True if Polyarm or a loaded plugin has a controller of this name, so that a built one needs kBuiltPrefix.
bool is_own_controller(const std::string& name);

}  // namespace polyarm::plugins
