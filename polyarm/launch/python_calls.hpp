#pragma once
/// What calls of launch files mean that need nothing but their arguments. Private to the room.
#include <string>

#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

/// The first argument, or the one of this name.
Value own_argument(const Arguments& a, const char* name);
/// dict(NAME=VALUE, …)
Value map_of(const Arguments& a);
/// Parts, or lists of parts, as one path.
Value path_of(const Arguments& a);
/// The value of an environment variable, or its default.
Value environment(const Arguments& a);
/// IfCondition and UnlessCondition: "true" or "false"; a gap where it is computed.
Value condition(bool unless, const Arguments& a);
/// What the condition of an action is; "true" without one.
std::string condition_of(const Arguments& a);
/// The action that runs a program.
bool is_process(const std::string& function);
/// parent, name, stem, suffix, parents of a path.
Value part_of_path(const Value& path, const std::string& name);
/// The name of a URDF or xacro file.
bool is_description(const std::string& file);

}  // namespace polyarm::ros_files::python
