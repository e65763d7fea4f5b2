#pragma once
/// `$(find …)`, `$(arg …)`, `$(eval …)` and their like in ROS 1 launch files.
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::ros_files {

/// The folder of a ROS package; an empty path where there is none. May throw Error.
using PackageSearch = std::function<std::filesystem::path(const std::string& package)>;

struct Substitution {
  std::map<std::string, std::string> args;  ///< declared and set so far
  std::filesystem::path folder;             ///< of the launch file: $(dirname)
  PackageSearch find;
  bool in_command = false;    ///< $(find xacro) need not exist: it only names the program
  bool keep_missing = false;  ///< $(find NAME) of a package that is not here stays as it is
};

/// `text` with everything in `$(…)` replaced; nested ones from the inside out. Throws Error without a place:
/// "no-package", "unknown-arg", "no-variable", "bad-substitution", "ros2-launch".
std::string substitute(std::string_view text, const Substitution& with);

/// Throws Error("no-package") where `text` still holds a $(find NAME) that was kept.
void refuse_missing_package(std::string_view text);

/// The Python expression of `$(eval …)`, by the evaluator of xacro's `${…}`, with arg(), find(), env(),
/// optenv(), dirname(), anon(), and args by their names. Nothing in it can run code. Throws Error without a
/// place.
std::string evaluate_launch_expression(std::string_view expression, const Substitution& with);

/// The value of `if` and `unless`: true, false, 1 or 0. Throws Error without a place.
bool launch_condition(const std::string& text);

/// Words as Python's shlex splits them, with '…', "…" and \ .
std::vector<std::string> shell_words(std::string_view text);

}  // namespace polyarm::ros_files
