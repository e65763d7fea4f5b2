#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/ros_packages/kit.hpp"
#include "polyarm/ros_packages/package.hpp"

namespace polyarm::apps {

/// What a build is asked for.
struct PluginBuild {
  std::filesystem::path scratch;  ///< build trees; empty: in the cache of the user
  bool simulated = false, verbose = false;
  unsigned jobs = 2;
};

/// The packages of `path`, and for a single package those beside it, which it may need. Packages of ROS that
/// the kit replaces are left out, except the only one that is asked for.
struct Workspace {
  std::vector<ros_packages::Package> asked, all;
};
Workspace open_workspace(const std::string& path, const ros_packages::Kit& kit, Problems& problems);

/// Builds one package's hardware classes into a module, records and approves it. Returns the module. Throws
/// Error("build-failed") with what is missing, by file and line, or with the compiler's first errors. Classes
/// that are described and not in the module, and plugins that were left out, become problems.
std::filesystem::path build_plugin(const ros_packages::Package& package, const Workspace& workspace,
                                   const ros_packages::Kit& kit, const PluginBuild& build,
                                   Problems& problems);

}  // namespace polyarm::apps
