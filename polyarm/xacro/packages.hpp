#pragma once
/// Finds ROS packages without ROS. Reads the disk.
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace polyarm::description {

/// Returns the folder of a package; an empty path if it is not found.
using PackageSearch = std::function<std::filesystem::path(const std::string& package)>;

/// Searches in this order: the `known` packages (name → folder); upwards from `file` for a folder whose
/// package.xml has the name (or that has the name itself), and beside each of these; the folders of
/// POLYARM_PACKAGES, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, at any depth down to 8 within 20,000 folders, as
/// ROS build tools do. Copies of the search share its results.
PackageSearch packages_near(const std::filesystem::path& file,
                            const std::map<std::string, std::filesystem::path>& known = {});

/// The only file below `package` whose path ends with `inside`; an empty path if there is none or more than
/// one.
std::filesystem::path find_inside(const std::filesystem::path& package, const std::filesystem::path& inside);

/// Descriptions in the folder of `file`, above and beside it, that include a file of this name, in order; at
/// most ten. Reads up to 500 files of at most 256 KiB.
std::vector<std::filesystem::path> files_that_include(const std::filesystem::path& file);

/// The files that match a path pattern with *, ? and […], in order.
std::vector<std::filesystem::path> files_matching(const std::filesystem::path& pattern);

}  // namespace polyarm::description
