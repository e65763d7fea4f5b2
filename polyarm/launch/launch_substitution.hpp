#pragma once
/// Replaces `$(find …)`, `$(arg …)`, `$(eval …)` and similar in ROS 1 launch files.
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::ros_files {

/// Returns the folder of a ROS package; an empty path if it is not found. May throw Error.
using PackageSearch = std::function<std::filesystem::path(const std::string& package)>;

struct Substitution {
  std::map<std::string, std::string> args;  ///< declared or set so far
  std::filesystem::path folder;             ///< of the launch file: $(dirname)
  PackageSearch find;
  bool in_command = false;    ///< $(find xacro) may be missing: it only names the program
  bool keep_missing = false;  ///< $(find NAME) of a missing package is not replaced
};

/// `text` with every `$(…)` replaced; nested ones from the inside out. Throws Error without a location:
/// "no-package", "unknown-arg", "no-variable", "bad-substitution", "ros2-launch".
std::string substitute(std::string_view text, const Substitution& with);

/// Throws Error("no-package") if `text` contains a $(find NAME) that was kept.
void refuse_missing_package(std::string_view text);

/// Evaluates the Python expression of `$(eval …)` with the evaluator of xacro's `${…}`. Adds arg(), find(),
/// env(), optenv(), dirname(), anon(), and args by name. It cannot run any code. Throws Error without a
/// location.
std::string evaluate_launch_expression(std::string_view expression, const Substitution& with);

/// The value of `if` and `unless`: true, false, 1 or 0. Throws Error without a location.
bool launch_condition(const std::string& text);

/// Splits words as Python's shlex does, with '…', "…" and \ .
std::vector<std::string> shell_words(std::string_view text);

}  // namespace polyarm::ros_files
