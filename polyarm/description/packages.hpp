#pragma once
/// Where ROS packages are, without ROS.
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace polyarm::description {

/// The folder of a package; an empty path where there is none.
using PackageSearch = std::function<std::filesystem::path(const std::string& package)>;

/// Looks, in this order: among `known` (name → folder); upwards from `file` for a folder with a package.xml
/// that has the name (or says it is its name), and beside each of these; in the folders of POLYARM_PACKAGES,
/// ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, there at any depth down to 8 within 20,000 folders, as build tools
/// of ROS do. Copies of the search share what was found.
PackageSearch packages_near(const std::filesystem::path& file,
                            const std::map<std::string, std::filesystem::path>& known = {});

/// The one file below `package` whose name ends as `inside` says; an empty path where there is none or
/// several.
std::filesystem::path find_inside(const std::filesystem::path& package, const std::filesystem::path& inside);

/// Descriptions in the folder of `file`, above and beside it that include a file of its name, in order;
/// at most ten. Looks at 500 files of at most 256 KiB.
std::vector<std::filesystem::path> files_that_include(const std::filesystem::path& file);

/// The files that a path with *, ? and […] in its parts means, in order.
std::vector<std::filesystem::path> files_matching(const std::filesystem::path& pattern);

}  // namespace polyarm::description
