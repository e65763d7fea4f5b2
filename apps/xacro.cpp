#include "polyarm/xacro/xacro.hpp"

#include <fmt/format.h>

#include "apps/options.hpp"
#include "polyarm/base/file.hpp"

namespace polyarm::apps {

int run_xacro(int argc, char** argv) {
  CommandLine app("Expands a description in xacro to URDF", "polyarm xacro");
  std::string file, output;
  std::vector<std::string> arguments, packages;
  bool deps = false, args = false;
  app.add_option("file", file, "the xacro file")->required();
  app.add_option("arguments", arguments, "NAME:=VALUE for its <xacro:arg>");
  app.add_option("-o,--output", output, "write there instead of to standard output");
  app.add_option("--package", packages, "NAME=FOLDER: where a package is; may be repeated");
  app.add_flag("--deps", deps, "list the files that it reads");
  app.add_flag("--args", args, "list its arguments and their values");
  app.footer(examples({"polyarm xacro robot.urdf.xacro",
                       "polyarm xacro robot.urdf.xacro use_mock_hardware:=true -o robot.urdf",
                       "polyarm xacro ur.urdf.xacro ur_type:=ur5e name:=ur --package "
                       "ur_description=~/ws/src/ur_description"}) +
             "\n$(find NAME) looks above the file for a package.xml, beside it, and where POLYARM_PACKAGES,\n"
             "ROS_PACKAGE_PATH and AMENT_PREFIX_PATH say.\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  description::XacroOptions options;
  options.arguments = named_values(arguments);
  for (const std::string& word : packages) {
    const auto at = word.find('=');
    if (at == std::string::npos) throw Error("bad-value", "--package " + word + " is not NAME=FOLDER");
    options.packages[word.substr(0, at)] = word.substr(at + 1);
  }
  Problems warnings;
  description::XacroReport report;
  const std::string urdf = description::expand_xacro(file, options, warnings, &report);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  if (deps)
    for (const auto& path : report.files) fmt::print("{}\n", path.string());
  if (args)
    for (const auto& [name, value] : report.arguments) fmt::print("{}:={}\n", name, value);
  if (deps || args) return kOk;
  if (output.empty())
    fmt::print("{}", urdf);
  else
    write_file_atomically(output, urdf);
  return kOk;
}

}  // namespace polyarm::apps
