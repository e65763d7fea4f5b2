#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/verb.hpp"
#include "polyarm/description/catalogue.hpp"

namespace polyarm::apps {

/// Parses; on --help or a wrong line it prints and returns the exit code to end with.
std::optional<int> parse(CLI::App& app, int argc, char** argv);
/// Text below the options in --help.
std::string examples(std::initializer_list<const char*> lines);
/// What --hardware takes: declared, a driver of Polyarm, or VENDOR/TYPE.
CLI::Validator hardware_name();
/// --plugins DIR, which may be repeated; load_plugins() takes the folders up before any other.
void add_plugin_option(CLI::App& app, std::vector<std::string>& folders);
void load_plugins(const std::vector<std::string>& folders);
/// NAME:=VALUE, as ROS writes the arguments of xacro and launch files. Error: bad-value.
std::map<std::string, std::string> named_values(const std::vector<std::string>& words);
/// The catalogue: folders of --catalogue first, then where it is installed.
description::Catalogue open_catalogue();

/// The robot that a verb is about: its name or file, what a file in xacro is told, which link has the tool.
struct AskedRobot {
  std::string name, tip;
  std::vector<std::string> arguments;

  CLI::Option* add_to(CLI::App& app,
                      const std::string& what = "catalogue name, or a URDF, xacro or robot file");
  description::RobotModel load(Problems& warnings, const description::Catalogue& catalogue) const;
};

}  // namespace polyarm::apps
