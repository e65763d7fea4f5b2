#pragma once
/// Where packages are: those that were built into the module in their source, others in ROS_PACKAGE_PATH,
/// POLYARM_PACKAGES and AMENT_PREFIX_PATH.
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace polyarm_ros {
/// Package → folder; made by `polyarm plugin build`.
inline std::map<std::string, std::string>& package_folders() {
  static std::map<std::string, std::string> all;
  return all;
}
}  // namespace polyarm_ros

namespace ament_index_cpp {

class PackageNotFoundError : public std::out_of_range {
 public:
  explicit PackageNotFoundError(const std::string& package)
      : std::out_of_range("package '" + package + "' not found"), package_name(package) {}
  const std::string package_name;
};

inline std::string get_package_share_directory(const std::string& package) {
  const auto& built = polyarm_ros::package_folders();
  if (const auto at = built.find(package); at != built.end()) return at->second;
  for (const char* variable : {"POLYARM_PACKAGES", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"}) {
    const char* text = std::getenv(variable);
    std::istringstream folders(text ? text : "");
    for (std::string folder; std::getline(folders, folder, ':');)
      for (const std::string& tried : {folder + "/share/" + package, folder + "/" + package, folder})
        if ((tried != folder || folder.size() > package.size()) &&
            ::access((tried + "/package.xml").c_str(), R_OK) == 0 &&
            tried.compare(tried.size() - package.size(), package.size(), package) == 0)
          return tried;
  }
  throw PackageNotFoundError(package);
}
inline std::string get_package_prefix(const std::string& package) {
  return get_package_share_directory(package);
}

}  // namespace ament_index_cpp
