#include "polyarm/cell/controllers_file.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"

namespace polyarm::cell {

namespace {
std::string last_name(const std::string& key) {
  return key.substr(key.rfind('/') + 1);
}

void flatten(const std::string& prefix, const Yaml& node, controllers::Parameters& out) {
  if (node.is_map()) {
    for (const std::string& key : node.keys())
      flatten(prefix.empty() ? key : prefix + "." + key, node[key], out);
    return;
  }
  controllers::Parameters::Entry entry;
  entry.where = node.where();
  for (const Yaml& item : node.items())
    if (item.is_scalar()) entry.values.push_back(item.text());
  out.entries[prefix] = std::move(entry);
}

/// The parameters of the node `name`, from every block of the file whose key means it.
controllers::Parameters parameters_of(const Yaml& file, const std::string& name) {
  controllers::Parameters out;
  for (const std::string& key : file.keys()) {
    if (key == "/**") {
      flatten("", file[key]["ros__parameters"], out);
      for (const std::string& inner : file[key].keys())
        if (last_name(inner) == name) flatten("", file[key][inner]["ros__parameters"], out);
    } else if (last_name(key) == name) {
      flatten("", file[key].has("ros__parameters") ? file[key]["ros__parameters"] : file[key], out);
    }
  }
  return out;
}
}  // namespace

ControllersFile read_controllers_file(const std::filesystem::path& path, Problems& warnings) {
  const Yaml yaml = Yaml::load(path.string());
  if (!yaml.is_map())
    throw Error(Problem{"not-controllers",
                        {path.string()},
                        "no controllers are described here",
                        "a controllers file has 'controller_manager: ros__parameters: …'"});
  ControllersFile out;
  const controllers::Parameters manager = parameters_of(yaml, "controller_manager");
  out.update_rate = manager.number("update_rate", 0);
  for (const auto& [key, entry] : manager.entries) {
    if (!key.ends_with(".type") || entry.values.empty()) continue;
    const std::string name = key.substr(0, key.size() - 5);
    if (name.find('.') != std::string::npos) continue;
    ControllerEntry controller{name, entry.values.front(), parameters_of(yaml, name), entry.where};
    out.controllers.push_back(std::move(controller));
  }
  std::sort(out.controllers.begin(), out.controllers.end(),
            [](const ControllerEntry& a, const ControllerEntry& b) { return a.where.line < b.where.line; });
  if (out.controllers.empty())
    warnings.warning(
        "no-controllers", {path.string(), 1, 1},
        "the file names no controllers: no 'controller_manager: ros__parameters: NAME: type: …' in it",
        "a joint trajectory controller for all joints is used");
  return out;
}

}  // namespace polyarm::cell
