#pragma once
/// Packages of ROS as they lie in a workspace: package.xml, and the plugin description files beside it. Files
/// of strangers: sizes, depth and numbers are bounded. Any thread; reads disk.
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/ros_packages/bounds.hpp"

namespace polyarm::ros_packages {


struct Dependency {
  std::string name;
  int line = 0;
  bool for_build = true;  ///< false: used when the robot runs, or by tests
};

struct Package {
  std::string name, version, build_type;  ///< build_type: "ament_cmake", "ament_python", "catkin"
  std::filesystem::path folder;
  std::vector<Dependency> dependencies;
  std::set<std::string> named_by_cmake;  ///< words that may be packages, in its CMakeLists.txt
  bool has_cmake() const;
};

/// Reads a package.xml. Throws Error("bad-package") with file and line.
Package read_package(const std::filesystem::path& file);
/// The packages in `path`: the package itself, or all below a workspace, in order of their folders. Folders
/// with COLCON_IGNORE or AMENT_IGNORE, hidden ones, and build, install and log are left out. A package that
/// cannot be read becomes a problem. Throws Error("no-package") if there is none.
std::vector<Package> find_packages(const std::filesystem::path& path, Problems& problems);
/// The packages that a single package may need: those beside it, then others of the same repository (.git) or
/// workspace (src).
std::vector<Package> packages_beside(const Package& package, Problems& problems);
/// Packages of other repositories that the package's own one lists for vcs (`*.repos` in the folders of the
/// package, its repository, and those between them), by the last word of their folder and of their address:
/// the address, and the file.
struct ListedSource {
  std::string address;
  std::filesystem::path file;
};
std::map<std::string, ListedSource> listed_sources(const Package& package);
/// `package` behind the packages of `all` that it needs, each after those that it needs itself. Cycles are
/// cut.
std::vector<const Package*> in_build_order(const Package& package, const std::vector<Package>& all);

/// A class of a plugin description file.
struct PluginClass {
  std::string name;  ///< as <plugin> in a robot's description has it
  std::string type, base, description, library;
  Location where;
  bool is_hardware() const;
  bool is_controller() const;
};
/// The hardware and the controllers of the package's plugin description files, in order of files and lines.
std::vector<PluginClass> plugin_classes(const Package& package);
/// Warns of each class whose base class is a misspelled one of hardware or controllers: plugin_classes leaves
/// it out. A base class of one of `all` is another class.
void check_bases(const Package& package, const std::vector<Package>& all, Problems& problems);
/// Its classes that plugins load while they run, filters and kinematics: those whose base class belongs to
/// one of `bases`, names of packages.
std::vector<PluginClass> helper_classes(const Package& package, const std::vector<const Package*>& bases);
/// The packages of `all` that are not in `order`, but have helper classes for it.
std::vector<const Package*> helpers_of(const std::vector<const Package*>& order,
                                       const std::vector<Package>& all);

}  // namespace polyarm::ros_packages
