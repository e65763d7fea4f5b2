#include "polyarm/hardware/driver_loader.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/base/installation.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/plugin_library.hpp"

namespace polyarm::hardware {

namespace {
std::map<std::string, ComponentFactory>& registered() {
  static std::map<std::string, ComponentFactory> drivers;
  return drivers;
}

constexpr const char* kPrefix = "polyarm_driver_";

std::filesystem::path find_library(const std::string& name) {
  std::error_code error;
  if (name.find('/') != std::string::npos) return {};  // a plugin's type, never a path
  for (const auto& folder : driver_folders()) {
    const auto path = folder / (kPrefix + name + ".so");
    if (std::filesystem::exists(path, error)) return path;
  }
  return {};
}
}  // namespace

void register_driver(const std::string& name, ComponentFactory factory) {
  registered()[name] = std::move(factory);
}

std::vector<std::filesystem::path> driver_folders() {
  std::vector<std::filesystem::path> out;
  if (const char* from_user = std::getenv("POLYARM_DRIVERS"))
    for (const std::string& folder : split_words(from_user, ":")) out.emplace_back(folder);
  for (const auto& folder : installation::program_folders()) out.push_back(folder);
  return out;
}

std::vector<std::string> driver_names() {
  std::vector<std::string> out;
  for (const auto& [name, factory] : registered()) out.push_back(name);
  for (const auto& folder : driver_folders()) {
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
      if (const std::string file = at->path().stem().string();
          file.starts_with(kPrefix) && at->path().extension() == ".so")
        out.push_back(file.substr(std::string_view(kPrefix).size()));
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

bool driver_available(const std::string& name) {
  return registered().contains(name) || !find_library(name).empty();
}

Problem unknown_driver(const std::string& name) {
  std::vector<std::string> names = driver_names();
  const std::string known = "known are: " + join(names, ", ");
  names.emplace_back("mujoco");
  std::string advice =
      name.find('/') == std::string::npos
          ? known
          : known + "; `polyarm plugins` lists plugins, and the refused ones with the reason";
  if (name == "mujoco") advice = "install libmujoco-dev and build again, or use --hardware mock";
  return {"unknown-driver",
          {},
          "there is no hardware driver '" + name + "'" + did_you_mean(name, names),
          std::move(advice)};
}

std::unique_ptr<Component> make_driver(const std::string& name) {
  if (const auto found = registered().find(name); found != registered().end()) return found->second();
  const auto path = find_library(name);
  if (path.empty()) throw Error(unknown_driver(name));
  const PluginTable& table = open_plugin(path);
  if (table.count != 1 || table.entries[0].kind != PluginKind::hardware)
    throw Error(
        Problem{"plugin-refused", {path.string()}, "it is not one driver", "end it with POLYARM_DRIVER(…)"});
  return make_component(table.entries[0], path);
}

}  // namespace polyarm::hardware
