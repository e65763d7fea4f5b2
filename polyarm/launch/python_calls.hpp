#pragma once
/// Functions that need only the arguments of a call in a launch file. Private to the room.
#include <string>

#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

/// The first positional argument, or the argument of this name.
Value own_argument(const Arguments& a, const char* name);
/// dict(NAME=VALUE, …)
Value map_of(const Arguments& a);
/// Joins parts, or lists of parts, to one path.
Value path_of(const Arguments& a);
/// The value of an environment variable, or its default.
Value environment(const Arguments& a);
/// IfCondition and UnlessCondition: "true" or "false"; a gap if the value is computed.
Value condition(bool unless, const Arguments& a);
/// The value of an action's condition; "true" if it has none.
std::string condition_of(const Arguments& a);
/// True if the action runs a program.
bool is_process(const std::string& function);
/// The parent, name, stem, suffix or parents of a path.
Value part_of_path(const Value& path, const std::string& name);
/// True if this is the name of a URDF or xacro file.
bool is_description(const std::string& file);

}  // namespace polyarm::ros_files::python
