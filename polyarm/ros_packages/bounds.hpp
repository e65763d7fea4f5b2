#pragma once
/// How much the readers of this room take: packages of ROS come from anywhere. docs/bounds.md has the same table.
#include <cstddef>
#include <string>

/// X(name, value, unit, what, beyond)
#define POLYARM_ROS_PACKAGES_BOUNDS(X)                                                                     \
  X(kLargestXml, 1 << 20, "bytes", "a package.xml or plugin description", "refused: too-large")            \
  X(kLargestInterface, 1 << 20, "bytes", "a .msg, .srv or .action file", "refused: too-large")             \
  X(kLargestParameterFile, 1 << 20, "bytes", "a parameter file", "refused: too-large")                     \
  X(kMostParameters, 5000, "parameters", "parameters of one file", "refused: bad-parameters")              \
  X(kDeepestParameter, 16, "levels", "parameters below each other", "refused: bad-parameters")             \
  X(kLargestSource, 4 << 20, "bytes", "a source that `plugin check` reads", "refused: too-large")          \
  X(kMostSources, 5000, "files", "sources of one package that it reads", "the others are not read")        \
  X(kMostProviders, 50, "packages", "packages of a workspace whose headers it knows without a dependency", \
    "only those of dependencies")                                                                          \
  X(kMostMeanings, 32, "values", "values of a variable of a build file", "the others are not read")        \
  X(kMostPackages, 2000, "packages", "packages of a workspace", "the others are not read")                 \
  X(kMostFolders, 20000, "folders", "folders in which packages are looked for", "the others are not read") \
  X(kDeepest, 8, "levels", "folders below each other in which packages are looked for", "not read")

namespace polyarm::ros_packages {

#define POLYARM_ROS_PACKAGES_BOUND(name, value, unit, what, beyond) inline constexpr std::size_t name = value;
POLYARM_ROS_PACKAGES_BOUNDS(POLYARM_ROS_PACKAGES_BOUND)
#undef POLYARM_ROS_PACKAGES_BOUND

/// As Markdown.
std::string bounds_table();

}  // namespace polyarm::ros_packages
