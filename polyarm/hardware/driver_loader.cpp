#include "polyarm/hardware/driver_loader.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::hardware {

namespace {
std::map<std::string, ComponentFactory>& registered() {
  static std::map<std::string, ComponentFactory> drivers;
  return drivers;
}

std::vector<std::filesystem::path> folders() {
  std::vector<std::filesystem::path> out;
  if (const char* from_user = std::getenv("POLYARM_DRIVERS"))
    for (const std::string& folder : split_words(from_user, ":")) out.emplace_back(folder);
  std::error_code error;
  const auto executable = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto here = executable.parent_path();
    for (const auto& folder :
         {here, here / "drivers", here.parent_path() / "drivers", here.parent_path() / "lib" / "polyarm"})
      out.push_back(folder);
  }
  return out;
}

std::filesystem::path find_library(const std::string& name) {
  std::error_code error;
  for (const auto& folder : folders()) {
    const auto path = folder / ("polyarm_driver_" + name + ".so");
    if (std::filesystem::exists(path, error)) return path;
  }
  return {};
}
}  // namespace

void register_driver(const std::string& name, ComponentFactory factory) {
  registered()[name] = factory;
}

bool driver_available(const std::string& name) {
  return registered().contains(name) || !find_library(name).empty();
}

std::unique_ptr<Component> make_driver(const std::string& name) {
  if (const auto found = registered().find(name); found != registered().end()) return found->second();
  const auto path = find_library(name);
  if (path.empty()) {
    std::vector<std::string> names{"mujoco"};
    for (const auto& [known, factory] : registered()) names.push_back(known);
    throw Error("unknown-driver", "there is no hardware driver '" + name + "'" + did_you_mean(name, names),
                name == "mujoco" ? "install libmujoco-dev and build again, or use --hardware mock"
                                 : "known are: " + join(names, ", "));
  }
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* make = library ? dlsym(library, "polyarm_make_component") : nullptr;
  if (!make) {
    const char* reason = dlerror();
    throw Error("driver-not-loadable",
                "the driver " + path.string() +
                    " cannot be loaded: " + (reason ? reason : "it exports no polyarm_make_component"),
                "install the libraries it needs, or use --hardware mock");
  }
  return std::unique_ptr<Component>(reinterpret_cast<Component* (*)()>(make)());
}

}  // namespace polyarm::hardware
