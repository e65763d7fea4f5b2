#pragma once
/// Command-line options that several verbs share.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "apps/verb.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::apps {

/// Examples for the text below the options in --help.
std::string examples(std::initializer_list<const char*> lines);
/// What is wrong with a value of --hardware: "declared", a driver of Polyarm, or VENDOR/TYPE. Empty if it is
/// valid.
std::string wrong_hardware(const std::string& name);
/// The repeatable option --plugins DIR. load_plugins() loads these folders before all others.
void add_plugin_option(CommandLine& app, std::vector<std::string>& folders);
void load_plugins(const std::vector<std::string>& folders);
/// Parses NAME:=VALUE, the ROS syntax for arguments of xacro and launch files. Throws WrongUse for anything
/// else; for numbers it suggests the option `of_numbers`, if given.
std::map<std::string, std::string> named_values(const std::vector<std::string>& words,
                                                const std::string& of_numbers = {});
/// The catalogue: folders of --catalogue first, then the installed one.
description::Catalogue open_catalogue();

/// The robot of a verb: its name or file, arguments of a xacro file, the link that has the tool, and
/// the arm that it is of a description with several.
struct RobotOption {
  std::string name, tip, branch;
  std::vector<std::string> arguments;
  std::string of_numbers;  ///< the verb's option that takes numbers

  Option* add_to(CommandLine& app,
                 const std::string& what = "catalogue name, or a URDF, xacro or robot file");
  description::RobotModel load(Problems& warnings, const description::Catalogue& catalogue) const;
};

}  // namespace polyarm::apps
