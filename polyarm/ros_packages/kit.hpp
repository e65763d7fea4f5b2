#pragma once
/// What Polyarm brings to build packages of ROS: headers, CMake functions, lists. Reads disk.
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/ros_packages/interface_code.hpp"

namespace polyarm::ros_packages {

/// Where something that is not Polyarm's comes from.
struct Source {
  std::string debian;  ///< the package of Debian and Ubuntu; empty: not in Debian
  std::string note;    ///< what to do without a package
  std::string advice() const;
};

class Kit {
 public:
  /// In the installation of this command, or in the tree that it was built in. Throws Error("no-kit").
  Kit();

  const std::filesystem::path& folder() const { return folder_; }    ///< has include/ and cmake/
  const std::filesystem::path& headers() const { return headers_; }  ///< Polyarm's own headers for plugins
  /// Throws Error("no-kit") if these are not installed.
  void require_headers() const;
  /// A hash of all headers that a plugin may include: those of the kit, of Polyarm, and of messages.
  std::string key() const;
  const std::vector<Interface>& interfaces() const { return interfaces_; }
  std::set<std::string> message_packages() const;
  /// A package of packages.list or of messages.
  bool has_package(const std::string& name) const;
  /// A package with headers or tools of the kit, other than messages. Sources of it in a workspace
  /// (ros2_control itself, say) are not built: they need the rest of ROS.
  bool replaces(const std::string& package) const { return replaced_.contains(package); }
  bool has_interface(const Interface& of) const;
  /// A header of the kit, or of a message ("std_msgs/msg/bool.hpp").
  bool has_header(const std::string& name) const;
  /// All identifiers in the kit's headers of a package.
  const std::set<std::string>& words(const std::string& package) const;
  /// Where a header or package that is neither ours nor here comes from; empty if nobody knows.
  std::optional<Source> source_of_header(const std::string& name) const;
  std::optional<Source> source_of_package(const std::string& name) const;

 private:
  std::filesystem::path folder_, headers_;
  std::vector<Interface> interfaces_;
  std::set<std::string> packages_, replaced_, message_headers_;
  std::map<std::string, Source> header_sources_, package_sources_;
  mutable std::map<std::string, std::set<std::string>> words_;
};

/// The identifiers of a C++ text outside comments and strings, each with the line of its first use.
std::map<std::string, int> identifiers(const std::string& code);

}  // namespace polyarm::ros_packages
