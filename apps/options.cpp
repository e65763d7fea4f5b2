#include "apps/options.hpp"

#include <algorithm>
#include <filesystem>

#include "polyarm/base/text.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/plugins/built.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/setup/cell_file.hpp"

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
  plugins::register_built();
}

description::Catalogue open_catalogue() {
  return description::Catalogue(description::default_catalogue_folders());
}

namespace {
/// The error for `words` with an entry that is not NAME:=VALUE.
WrongUse not_named(const std::vector<std::string>& words, const std::string& of_numbers) {
  std::vector<std::string> numbers;
  for (const std::string& word : words) {
    const bool starts_as_number =
        word.find_first_of("0123456789") <= 1 && word.find(":=") == std::string::npos;
    if (starts_as_number) numbers.push_back(word);
  }
  if (numbers.empty() || of_numbers.empty()) {
    const auto named = [](const std::string& word) { return word.find(":=") + 1 > 1; };
    const std::string wrong = *std::find_if_not(words.begin(), words.end(), named);
    return {"bad-value", "nothing takes '" + wrong + "' here",
            "arguments of a description in xacro are NAME:=VALUE; --help lists the options"};
  }
  const std::string all = join(numbers, " ");
  return {"bad-value", "no option takes the number" + std::string(numbers.size() == 1 ? " " : "s ") + all,
          "write " + of_numbers + " " + all};
}
}  // namespace

std::map<std::string, std::string> named_values(const std::vector<std::string>& words,
                                                const std::string& of_numbers) {
  std::map<std::string, std::string> out;
  for (const std::string& word : words) {
    const auto at = word.find(":=");
    if (at == std::string::npos || at == 0) throw not_named(words, of_numbers);
    out[word.substr(0, at)] = word.substr(at + 2);
  }
  return out;
}

Option* RobotOption::add_to(CommandLine& app, const std::string& what) {
  Option* robot = app.add_option("robot", name, what);
  app.add_option("arguments", arguments, "NAME:=VALUE of a description in xacro");
  app.add_option("--tip", tip, "the link that carries the tool (else the flange or palm that is found)");
  app.add_option("--branch", branch, "only the arm with this link, of a description with several arms");
  return robot;
}

namespace {
/// Refuses a cell where a robot is expected, and names the robots of the cell.
void refuse_cell(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::exists(fs::path(name) / "cell.yaml", ignored)) return;
  std::vector<std::string> models;
  for (const cell::RobotEntry& robot : cell::read_cell_file(name).robots) models.push_back(robot.model);
  throw WrongUse("no-robot", "'" + name + "' is a cell, and this verb is about one robot",
                 models.empty() ? "the cell has none" : "its robots are " + join(models, ", "));
}
}  // namespace

description::RobotModel RobotOption::load(Problems& warnings, const description::Catalogue& catalogue) const {
  refuse_cell(name);
  Problems found;
  description::RobotModel model =
      description::load_robot(name, catalogue, found, named_values(arguments, of_numbers));
  for (Problem problem : found.list()) {
    if (problem.severity == Severity::error) {
      problem.severity = Severity::warning;
      problem.what += "; `polyarm run` refuses this, kinematics works without its hardware";
    }
    warnings.add(std::move(problem));
  }
  description::keep_branch(model, branch);
  description::set_tip(model, tip);
  return model;
}

}  // namespace polyarm::apps
