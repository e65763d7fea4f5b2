#pragma once
/// Reads YAML as xacro's load_yaml does: version 1.1, with units. Private to this room.
#include <functional>
#include <string>

#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::description {

/// Maps keep the order of their keys. If a key is repeated, its last value counts. "<<" merges the keys of
/// other maps. Plain words become numbers, booleans and nulls as in YAML 1.1. A value tagged !degrees,
/// !radians, !meters, !millimeters, !foot or !inches is an expression for `evaluate` and becomes radians or
/// metres. `file` is the name in messages. Throws Error with the place.
XacroValue read_yaml(const std::string& text, const std::string& file,
                     const std::function<XacroValue(const std::string& expression)>& evaluate);

}  // namespace polyarm::description
