#pragma once
/// Makes classes of the same module by name. Plugins of other packages are found if their package is built
/// into it.
#include <memory>
#include <string>
#include <vector>

#include "pluginlib/class_list_macros.hpp"
#include "pluginlib/exceptions.hpp"

namespace polyarm_ros {
/// C++ type of a name in the plugin description files of the module; made by `polyarm plugin build`.
inline std::map<std::string, std::string>& described_types() {
  static std::map<std::string, std::string> all;
  return all;
}
}  // namespace polyarm_ros

namespace pluginlib {

template <typename T>
using UniquePtr = std::unique_ptr<T>;

template <class Base>
class ClassLoader {
 public:
  ClassLoader(std::string, std::string base, std::string = "", std::vector<std::string> = {})
      : base_(std::move(base)) {}
  std::unique_ptr<Base> createUniqueInstance(const std::string& name) {
    return std::unique_ptr<Base>(make(name));
  }
  std::shared_ptr<Base> createSharedInstance(const std::string& name) {
    return std::shared_ptr<Base>(make(name));
  }
  Base* createUnmanagedInstance(const std::string& name) { return make(name); }
  bool isClassAvailable(const std::string& name) { return find(name) != nullptr; }
  std::vector<std::string> getDeclaredClasses() {
    std::vector<std::string> out;
    for (const auto& [name, type] : polyarm_ros::described_types())
      if (find(name)) out.push_back(name);
    return out;
  }

 private:
  const polyarm_ros::ExportedClass* find(const std::string& name) {
    const auto described = polyarm_ros::described_types().find(name);
    const auto& all = polyarm_ros::exported_classes();
    const auto found = all.find(described == polyarm_ros::described_types().end() ? name : described->second);
    return found == all.end() || base_ != found->second.base ? nullptr : &found->second;
  }
  Base* make(const std::string& name) {
    const polyarm_ros::ExportedClass* found = find(name);
    if (!found)
      throw LibraryLoadException("no class '" + name + "' with the base " + base_ +
                                 " is built into this module");
    return static_cast<Base*>(found->make());
  }
  std::string base_;
};

}  // namespace pluginlib
