#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "apps/verb.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::apps {

/// Text below the options in --help.
std::string examples(std::initializer_list<const char*> lines);
/// What is wrong with a name for --hardware, which takes declared, a driver of Polyarm, or VENDOR/TYPE.
std::string wrong_hardware(const std::string& name);
/// --plugins DIR, which may be repeated; load_plugins() takes the folders up before any other, then knows the
/// plugins that `polyarm plugin build` made.
void add_plugin_option(CommandLine& app, std::vector<std::string>& folders);
void load_plugins(const std::vector<std::string>& folders);
/// NAME:=VALUE, as ROS writes the arguments of xacro and launch files. Throws WrongUse for anything else, and
/// says for numbers that they follow `of_numbers`, if that is an option of the verb.
std::map<std::string, std::string> named_values(const std::vector<std::string>& words,
                                                const std::string& of_numbers = {});
/// The catalogue: folders of --catalogue first, then where it is installed.
description::Catalogue open_catalogue();

/// The robot that a verb is about: its name or file, what a file in xacro is told, which link has the tool.
struct AskedRobot {
  std::string name, tip;
  std::vector<std::string> arguments;
  std::string of_numbers;  ///< the option of the verb that numbers follow

  Option* add_to(CommandLine& app,
                 const std::string& what = "catalogue name, or a URDF, xacro or robot file");
  description::RobotModel load(Problems& warnings, const description::Catalogue& catalogue) const;
};

}  // namespace polyarm::apps
