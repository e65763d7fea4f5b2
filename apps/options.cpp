#include "apps/options.hpp"

#include "polyarm/plugins/plugins.hpp"

namespace polyarm::apps {

std::string examples(std::initializer_list<const char*> lines) {
  std::string out = "Examples:\n";
  for (const char* line : lines) out += std::string("  ") + line + "\n";
  return out;
}

std::string wrong_hardware(const std::string& name) {
  for (const char* known : {"declared", "mock", "mujoco"})
    if (name == known) return {};
  if (name.find('/') != std::string::npos) return {};
  return "'" + name + "' is not declared, mock, mujoco or VENDOR/TYPE";
}

void add_plugin_option(CommandLine& app, std::vector<std::string>& folders) {
  app.add_option("--plugins", folders, "folder with plugins; may be repeated")->existing_folder();
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
                  word.find_first_not_of("0123456789.-+eE") == std::string::npos
                      ? "numbers follow an option, such as --joints or --xyz"
                      : "arguments of a description come as NAME:=VALUE");
    out[word.substr(0, at)] = word.substr(at + 2);
  }
  return out;
}

Option* AskedRobot::add_to(CommandLine& app, const std::string& what) {
  Option* robot = app.add_option("robot", name, what);
  app.add_option("arguments", arguments, "NAME:=VALUE of a description in xacro");
  app.add_option("--tip", tip, "the link that carries the tool (else the flange or palm that is found)");
  return robot;
}

description::RobotModel AskedRobot::load(Problems& warnings, const description::Catalogue& catalogue) const {
  Problems found;
  description::RobotModel model = description::load_robot(name, catalogue, found, named_values(arguments));
  for (Problem problem : found.list()) {
    if (problem.severity == Severity::error) {
      problem.severity = Severity::warning;
      problem.what += "; `polyarm run` refuses this, kinematics goes on without its hardware";
    }
    warnings.add(std::move(problem));
  }
  description::set_tip(model, tip);
  return model;
}

}  // namespace polyarm::apps
