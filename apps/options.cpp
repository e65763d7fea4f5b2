#include "apps/options.hpp"

#include <algorithm>
#include <cctype>

#include "polyarm/plugins/plugins.hpp"

namespace polyarm::apps {

namespace {
bool is_named_value(const std::string& word) {
  const auto at = word.find(":=");
  return at != std::string::npos && at > 0 &&
         std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(at),
                     [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}
}  // namespace

std::optional<int> parse(CLI::App& app, int argc, char** argv) {
  try {
    std::vector<std::string> words(argv + 1, argv + argc);
    // An option that takes many values would take what stands behind them, too.
    if (std::find(words.begin(), words.end(), "--") == words.end()) {
      const auto named = std::stable_partition(words.begin(), words.end(),
                                               [](const std::string& word) { return !is_named_value(word); });
      if (named != words.end()) words.insert(named, "--");
    }
    std::reverse(words.begin(), words.end());
    app.parse(std::move(words));
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? kOk : kUsage;
  }
}

std::string examples(std::initializer_list<const char*> lines) {
  std::string out = "Examples:\n";
  for (const char* line : lines) out += std::string("  ") + line + "\n";
  return out;
}

CLI::Validator hardware_name() {
  return {[](const std::string& name) -> std::string {
            for (const char* known : {"declared", "mock", "mujoco"})
              if (name == known) return {};
            return name.find('/') != std::string::npos
                       ? ""
                       : "'" + name + "' is not declared, mock, mujoco or VENDOR/TYPE";
          },
          "NAME"};
}

void add_plugin_option(CLI::App& app, std::vector<std::string>& folders) {
  app.add_option("--plugins", folders, "folder with plugins; may be repeated")->check(CLI::ExistingDirectory);
}

void load_plugins(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) plugins::load_folder(folder);
}

description::Catalogue open_catalogue() {
  return description::Catalogue(description::default_catalogue_folders());
}

std::map<std::string, std::string> named_values(const std::vector<std::string>& words) {
  std::map<std::string, std::string> out;
  for (const std::string& word : words) {
    const auto at = word.find(":=");
    if (at == std::string::npos || at == 0)
      throw Error("bad-value", "'" + word + "' is not NAME:=VALUE",
                  "arguments of a description come as NAME:=VALUE");
    out[word.substr(0, at)] = word.substr(at + 2);
  }
  return out;
}

CLI::Option* AskedRobot::add_to(CLI::App& app, const std::string& what) {
  CLI::Option* robot = app.add_option("robot", name, what);
  app.add_option("arguments", arguments, "NAME:=VALUE of a description in xacro");
  app.add_option("--tip", tip, "the link that carries the tool (else the flange or palm that is found)");
  return robot;
}

description::RobotModel AskedRobot::load(Problems& warnings, const description::Catalogue& catalogue) const {
  description::RobotModel model = description::load_robot(name, catalogue, warnings, named_values(arguments));
  description::set_tip(model, tip);
  return model;
}

}  // namespace polyarm::apps
