/// `polyarm plugin`: hardware plugins and controllers of ros2_control, built from their source without ROS.
#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "apps/options.hpp"
#include "apps/plugin_build.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/plugins/built.hpp"
#include "polyarm/ros_packages/check.hpp"
#include "polyarm/ros_packages/parameter_code.hpp"

namespace polyarm::apps {

namespace {
namespace fs = std::filesystem;
using ros_packages::Package;

struct Asked {
  const Package* package;
  std::vector<ros_packages::PluginClass> classes;
};

/// The packages with hardware or controllers.
std::vector<Asked> packages_with_plugins(const Workspace& workspace) {
  std::vector<Asked> out;
  for (const Package& package : workspace.asked) {
    std::vector<ros_packages::PluginClass> classes = ros_packages::plugin_classes(package);
    if (!classes.empty()) out.push_back({&package, std::move(classes)});
  }
  if (out.empty())
    throw Error("no-plugin", "no package here describes a hardware plugin or a controller",
                "its XML file has <class type=\"…\" "
                "base_class_type=\"hardware_interface::SystemInterface\">, as pluginlib needs it");
  return out;
}

void print_all(const std::vector<Problem>& problems) {
  for (const Problem& problem : problems) fmt::print(stderr, "{}\n", problem.text());
}

/// How a robot's description or a controllers file names the class.
void print_class(const ros_packages::PluginClass& c, bool simulated) {
  if (c.is_hardware())
    fmt::print("  <plugin>{}</plugin>{}\n", c.name, simulated ? "" : "  real hardware: run it with --real");
  else if (plugins::is_own_controller(c.name))
    fmt::print("  type: {}{}  (without '{}' it is Polyarm's own)\n", plugins::kBuiltPrefix, c.name,
               plugins::kBuiltPrefix);
  else
    fmt::print("  type: {}\n", c.name);
}

int run_build(int argc, char** argv) {
  CommandLine app(
      "Builds the hardware plugins and controllers of a package or workspace for this Polyarm; needs cmake and a C++ "
      "compiler, no ROS",
      "polyarm plugin build");
  std::string path;
  PluginBuild build;
  build.jobs = std::max(1u, std::thread::hardware_concurrency());
  app.add_option("path", path, "a package's folder, or a workspace with packages in it")
      ->required()
      ->existing_folder();
  app.add_flag("--simulated", build.simulated, "this hardware moves nothing real: it runs without --real");
  app.add_option("--build-dir", build.scratch, "build folder (default: ~/.cache/polyarm/plugins)");
  app.add_option("--jobs", build.jobs, "compilers side by side");
  app.footer(
      examples({"polyarm plugin build my_robot_hardware", "polyarm plugin build ros2_ws/src --simulated"}) +
      "\nThe build runs the packages' own CMake files and compiles their code.\n"
      "Exit codes: 0 all were built, 1 some were not, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ros_packages::Kit kit;
  Problems problems;
  const Workspace workspace = open_workspace(path, kit, problems);
  print_all(problems.list());
  bool all = true;
  for (const Asked& asked : packages_with_plugins(workspace)) {
    try {
      Problems left_out;
      const fs::path module = build_plugin(*asked.package, workspace, kit, build, left_out);
      print_all(left_out.list());
      fmt::print("built {}\n", module.string());
      const auto known = plugins::built_classes();
      for (const auto& c : asked.classes)
        if (std::any_of(known.begin(), known.end(),
                        [&](const auto& k) { return k.name == c.name && k.module == module; }))
          print_class(c, build.simulated);
    } catch (const Error& e) {
      all = false;
      print_all(e.problems());
    }
  }
  return all ? kOk : kFailed;
}

int run_check_plugin(int argc, char** argv) {
  CommandLine app(
      "Lists what a package needs and is missing here: headers, packages, names of ROS that Polyarm does not "
      "have",
      "polyarm plugin check");
  std::string path;
  app.add_option("path", path, "a package's folder, or a workspace with packages in it")
      ->required()
      ->existing_folder();
  app.footer(examples({"polyarm plugin check my_robot_hardware"}) +
             "\nReads the sources; compiles and runs nothing.\nExit codes: 0 nothing is missing, 1 something "
             "is, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ros_packages::Kit kit;
  Problems problems;
  const Workspace workspace = open_workspace(path, kit, problems);
  print_all(problems.list());
  Problems found;
  for (const Asked& asked : packages_with_plugins(workspace)) {
    Problems of_package;
    ros_packages::check_package(*asked.package, workspace.all, kit, of_package);
    const auto missing = std::count_if(of_package.list().begin(), of_package.list().end(),
                                       [](const Problem& p) { return p.severity == Severity::error; });
    fmt::print("{}: {}\n", asked.package->name,
               missing == 0 ? "nothing is missing" : fmt::format("{} missing", missing));
    for (const Problem& problem : of_package.list()) found.add(problem);
  }
  print_all(found.list());
  return problems.has_errors() || found.has_errors() ? kFailed : kOk;
}

int run_list(int argc, char** argv) {
  CommandLine app("Lists the plugins that were built here", "polyarm plugin list");
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto all = plugins::built_classes();
  for (const auto& each : all) {
    const bool controller = each.kind == hardware::PluginKind::controller;
    fmt::print("{:<58} {}\n",
               (controller && plugins::is_own_controller(each.name) ? plugins::kBuiltPrefix : "") + each.name,
               each.module.string());
  }
  if (all.empty()) fmt::print("nothing was built\n");
  return kOk;
}

/// For the build files of packages: the header of a parameter file.
int run_parameters_of_package(int argc, char** argv) {
  CommandLine app("Writes the C++ header of a parameter file of generate_parameter_library",
                  "polyarm plugin parameters");
  std::string file, out, validators;
  app.add_option("file", file, "the YAML file")->required();
  app.add_option("--out", out, "the header")->required();
  app.add_option("--validators", validators, "the header with validators of the package, as #include has it");
  if (const auto code = app.parse(argc, argv)) return *code;
  const std::string text = read_file(file, ros_packages::kLargestParameterFile);
  const std::string header = ros_packages::parameter_header(text, file, validators);
  fs::create_directories(fs::path(out).parent_path());
  std::error_code error;
  if (fs::exists(out, error) && read_file(out, std::size_t{16} << 20) == header) return kOk;
  write_file_atomically(out, header);
  return kOk;
}

/// For the build files of packages: structs of their own interfaces.
int run_interfaces_of_package(int argc, char** argv) {
  CommandLine app(
      "Writes C++ structs of .msg, .srv and .action files; without files, of those that Polyarm has",
      "polyarm plugin interfaces");
  std::string package, out;
  std::vector<std::string> files;
  app.add_option("--package", package, "the name of their package");
  app.add_option("--out", out, "folder that gets PACKAGE/msg/name.hpp")->required();
  app.add_option("file", files, "the files");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::vector<ros_packages::Interface> all;
  const ros_packages::Kit kit;
  if (files.empty()) all = kit.interfaces();
  for (const std::string& file : files) {
    ros_packages::Interface read = ros_packages::read_interface(package, file);
    if (!kit.has_interface(read)) all.push_back(std::move(read));  // those of the kit are always there
  }
  ros_packages::write_headers(all, out);
  return kOk;
}
}  // namespace

int run_plugin(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  if (word == "build") return run_build(argc - 1, argv + 1);
  if (word == "check") return run_check_plugin(argc - 1, argv + 1);
  if (word == "list") return run_list(argc - 1, argv + 1);
  if (word == "parameters") return run_parameters_of_package(argc - 1, argv + 1);
  if (word == "interfaces") return run_interfaces_of_package(argc - 1, argv + 1);
  CommandLine app("Hardware plugins and controllers of ros2_control, built from their source without ROS", "polyarm plugin");
  std::string verb;
  app.add_option("verb", verb, "build, check, list, interfaces or parameters")
      ->required()
      ->one_of({"build", "check", "list", "interfaces", "parameters"});
  app.footer(examples({"polyarm plugin check my_robot_hardware", "polyarm plugin build my_robot_hardware",
                       "polyarm plugin list"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  return kUsage;
}

}  // namespace polyarm::apps
