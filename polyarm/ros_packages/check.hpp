#pragma once
/// What a package needs and nobody here has: headers, packages, and names of ROS that do not exist in the
/// kit. Reads the sources; compiles nothing.
#include <vector>

#include "polyarm/ros_packages/kit.hpp"
#include "polyarm/ros_packages/package.hpp"

namespace polyarm::ros_packages {

/// Adds one error for each header, package and name, at the place of its first use. `all` are the packages of
/// the workspace, which provide headers too.
void check_package(const Package& package, const std::vector<Package>& all, const Kit& kit,
                   Problems& problems);

/// True if a class of the package overrides configure, start and stop of the hardware interface itself, as in
/// the first releases of ROS 2 Foxy.
bool overrides_configure(const Package& package);

}  // namespace polyarm::ros_packages
