#include "apps/asked_cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/example_cell.hpp"
#include "apps/options.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/launch/python_launch.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

void print_taken(const ros_files::PythonLaunch& read, const std::string& path) {
  std::error_code error;
  const auto missing = [&](const fs::path& file) {
    return fs::is_regular_file(file, error) ? "" : ", which does not exist";
  };
  const auto in_line = [&](const Location& where) {
    if (where.line <= 0) return std::string();
    const std::string inside = where.file == path ? "" : fs::path(where.file).filename().string() + " ";
    return fmt::format(" ({}line {})", inside, where.line);
  };
  for (const auto& found : read.descriptions)
    fmt::print(stderr, "  taken: description  {}{}{}\n", found.file.string(), in_line(found.where),
               missing(found.file));
  for (const auto& found : read.parameters)
    fmt::print(stderr, "  taken: controllers  {}{}{}\n", found.file.string(), in_line(found.where),
               missing(found.file));
  for (const auto& argument : read.arguments)
    if (argument.known)
      fmt::print(stderr, "  taken: argument     {}:={}{}\n", argument.name, argument.value,
                 argument.given ? "" : " (its default)");
  for (const auto& [where, what] : read.not_taken)
    fmt::print(stderr, "  not taken: {}{}\n", what, in_line(where));
  if (!read.missing_packages.empty())
    fmt::print(stderr,
               "not found: the package{} {}; with POLYARM_PACKAGES=FOLDER before the command, FOLDER and the "
               "folders below it are searched, too\n",
               read.missing_packages.size() > 1 ? "s" : "", join(read.missing_packages, ", "));
}

/// Prints what the printed command line does not contain.
void print_needs(const ros_files::PythonLaunch& read, const std::string& verb) {
  for (const ros_files::PythonLaunchNeed& need : read.needed()) {
    const auto argument = std::find_if(read.arguments.begin(), read.arguments.end(),
                                       [&](const auto& other) { return other.name == need.argument; });
    const bool choices = argument != read.arguments.end() && !argument->choices.empty();
    fmt::print(
        stderr, "replace VALUE of {}: {}{}\n", need.name,
        need.argument.empty()
            ? "the description needs it, and the launch file computes it"
            : fmt::format("the argument '{}' of the launch file has no literal default", need.argument),
        choices ? "; it is one of " + join(argument->choices, ", ") : "");
  }
  if (const std::string why = read.why_no_activate(); verb == "run" && !why.empty())
    fmt::print(stderr, "--activate is left out: {}{}\n", why,
               read.spawned.empty()
                   ? ""
                   : "; add --activate NAME for those you want (" + join(read.spawned, ", ") + ")");
}

/// Controllers' files that the description itself names for Gazebo.
std::vector<ros_files::PythonLaunchFile> controllers_of(
    const ros_files::PythonLaunchDescription& description) {
  std::vector<ros_files::PythonLaunchFile> out;
  Problems ignored;
  std::error_code error;
  collect(ignored, [&] {
    const std::map<std::string, std::string> arguments(description.arguments.begin(),
                                                       description.arguments.end());
    const auto model =
        description::load_robot(description.file.string(), description::Catalogue({}), ignored, arguments);
    for (const std::string& file : model.controller_files)
      if (fs::is_regular_file(file, error)) out.push_back({file, description.where});
  });
  return out;
}

/// Prints what a ROS 2 launch file states explicitly, and the command line for `verb`.
int explain_launch_file(const std::string& verb, const std::string& path,
                        const std::map<std::string, std::string>& given) {
  ros_files::PythonLaunch read =
      ros_files::read_python_launch(read_file(path), path, given, description::packages_near(path));
  fmt::print(stderr, "polyarm {}: {} is a {}launch file of ROS 2, which is read and not executed\n", verb,
             path, path.ends_with(".py") ? "Python " : "");
  std::error_code error;
  if (!read.descriptions.empty() && read.parameters.empty())
    read.parameters = controllers_of(read.descriptions.front());
  print_taken(read, path);
  const auto missing = [&](const auto& found) { return !fs::is_regular_file(found.file, error); };
  std::erase_if(read.descriptions, missing);
  std::erase_if(read.parameters, missing);
  if (!read.descriptions.empty()) {
    if (read.descriptions.size() > 1)
      fmt::print(stderr, "it has several descriptions; the first is used below\n");
    print_needs(read, verb);
    fmt::print(stderr, "type instead:\n  {}\n", read.line(verb));
    return kUsage;
  }
  const std::vector<std::string> lines = ros_files::lines_of_package(path, verb);
  const description::LaunchHints hints = description::find_in_launch_file(read_file(path));
  if (!lines.empty()) {
    fmt::print(stderr,
               "it names no description that exists here; its packages have these. Type for example\n");
    for (const std::string& line : lines) fmt::print(stderr, "  {}\n", line);
  } else if (!hints.descriptions.empty()) {
    fmt::print(stderr,
               "it names no description that exists here. Type this, with the paths of its files\n  {}\n",
               hints.line(verb));
  } else {
    fmt::print(stderr,
               "it names no description; if it belongs to a robot, type\n"
               "  polyarm {} --description FILE.urdf --controllers FILE.yaml\n",
               verb);
  }
  return kUsage;
}

/// True for a ROS 2 launch file: any Python file, or XML or YAML with a launch description.
bool is_ros2_launch(const std::string& named) {
  std::error_code error;
  const fs::path path = named;
  const std::string extension = path.extension().string();
  if (extension == ".py") return true;
  const bool markup =
      extension == ".launch" || extension == ".xml" || extension == ".yaml" || extension == ".yml";
  if (!markup || named.find("launch") == std::string::npos || !fs::is_regular_file(path, error)) return false;
  std::string text;
  Problems ignored;
  collect(ignored, [&] { text = read_file(path); });
  return ros_files::is_ros2_launch(text, path);
}

/// True for a description or a catalogue robot, which can be named instead of a cell.
bool is_robot(const std::string& named) {
  std::error_code error;
  const fs::path path = named;
  if (fs::is_regular_file(path, error)) return path.extension() == ".urdf" || path.extension() == ".xacro";
  if (named.empty() || fs::exists(path, error)) return false;
  return open_catalogue().find(named).has_value();
}

}  // namespace

void CellOption::add_to(CommandLine& app) {
  app.add_option("cell", cell,
                 "folder with a cell.yaml, a cell file, the name of an example, a launch file of ROS 1, or a "
                 "robot: a URDF, xacro or catalogue name");
  app.add_option("arguments", arguments, "NAME:=VALUE of a launch file or of a description in xacro");
  app.add_option("--description", description,
                 "a robot's URDF or xacro, or its catalogue name, instead of a cell");
  app.add_option("--controllers", controllers, "controllers YAML for --description; may be repeated");
  app.add_option("--branch", branch,
                 "with a robot: only the arm with this link, of a description with several");
}

std::optional<int> CellOption::settle(const std::string& verb) {
  if (!description.empty() && cell.find(":=") != std::string::npos)
    arguments.insert(arguments.begin(), std::exchange(cell, ""));
  if (description.empty() && is_robot(cell)) description = std::exchange(cell, "");
  std::error_code error;
  if (!cell.empty() && description.empty() && !fs::exists(cell, error))
    if (const auto own = own_copy_of_example(cell)) cell = own->string();
  const std::string named = cell.empty() ? description : cell;
  if (cell.empty() == description.empty()) {
    fmt::print(stderr,
               "polyarm {0}: name a cell, or a robot with --description FILE.urdf; see polyarm {0} --help\n",
               verb);
    return kUsage;
  }
  if (!branch.empty() && description.empty()) {
    fmt::print(stderr, "polyarm {}: --branch goes with a robot; in a cell, write 'branch: {}' to a robot\n",
               verb, branch);
    return kUsage;
  }
  if (is_ros2_launch(named)) return explain_launch_file(verb, named, named_values(arguments));
  return std::nullopt;
}

namespace {
/// The launch file starts no robot here: suggests other files of its package.
[[noreturn]] void refuse_launch_file(const std::string& path, const Error& error) {
  std::vector<Problem> problems = error.problems();
  const auto lines = ros_files::lines_of_package(path, "run");
  for (Problem& problem : problems)
    if (!lines.empty() && (problem.code == "ros2-launch" || problem.code == "no-description"))
      problem.advice = "its packages have descriptions, type for example: " + join(lines, "; or: ");
  throw Error(std::move(problems));
}
}  // namespace

cell::CellFile CellOption::open() const {
  if (description::is_launch_file(cell)) {
    Problems problems;
    cell::CellFile launched;
    try {
      launched = cell::cell_from_launch(cell, named_values(arguments), overrides, problems);
    } catch (const Error& e) {
      refuse_launch_file(cell, e);
    }
    for (const Problem& problem : problems.list()) launched.notes.push_back(problem.text());
    if (!activate.empty()) launched.activate = activate;
    return launched;
  }
  cell::CellFile file = description.empty()
                            ? cell::read_cell_file(cell, overrides)
                            : cell::cell_from_description(description, controllers, overrides);
  for (const auto& [name, value] : named_values(arguments))
    for (cell::RobotEntry& robot : file.robots) robot.arguments[name] = value;
  if (!branch.empty())
    for (cell::RobotEntry& robot : file.robots) robot.branch = branch;
  if (!activate.empty()) file.activate = activate;
  return file;
}

}  // namespace polyarm::apps
