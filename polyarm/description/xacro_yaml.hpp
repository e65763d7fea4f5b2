#pragma once
/// YAML as xacro's load_yaml reads it: version 1.1, with units. Private to the room.
#include <functional>
#include <string>

#include "polyarm/description/xacro_value.hpp"

namespace polyarm::description {

/// Maps keep the order of their keys; of a key that stands twice the last value holds; "<<" takes over the
/// keys of other maps. Plain words become the numbers, truth values and nulls that YAML 1.1 takes them for.
/// What is tagged !degrees, !radians, !meters, !millimeters, !foot or !inches is an expression that
/// `evaluate` reads; it becomes radians or metres. `file` is told in complaints. Throws Error with the place.
XacroValue read_yaml(const std::string& text, const std::string& file,
                     const std::function<XacroValue(const std::string& expression)>& evaluate);

}  // namespace polyarm::description
