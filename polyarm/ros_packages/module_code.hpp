#pragma once
/// The two files that `polyarm plugin build` writes for each package: the module's C++ table and its
/// CMakeLists.txt.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/ros_packages/kit.hpp"
#include "polyarm/ros_packages/package.hpp"

namespace polyarm::ros_packages {

struct ModuleOptions {
  bool simulated = false;                         ///< the hardware moves nothing real
  std::filesystem::path command, generated, out;  ///< this program; structs of messages; folder of the module
  std::filesystem::path shared;                   ///< folder of what is compiled once for all modules
};

/// The table with the hardware and the controllers of `package`. `order`: the packages that are built into
/// it, with those whose filters and kinematics it may load.
std::string module_code(const Package& package, const std::vector<PluginClass>& classes,
                        const std::vector<const Package*>& order, const ModuleOptions& options);
std::string module_cmake(const Package& package, const std::vector<PluginClass>& classes,
                         const std::vector<const Package*>& order, const Kit& kit,
                         const ModuleOptions& options);

}  // namespace polyarm::ros_packages
