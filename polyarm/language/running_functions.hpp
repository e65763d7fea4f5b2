#pragma once
/// Functions whose results depend on when the program calls them: of its robot, its belts, its streams. Part
/// of the list in functions.hpp. Any thread.
#include <vector>

#include "polyarm/language/functions.hpp"

namespace polyarm::program {

/// here_joints, ik, random, force, next_part, next_line, …
void add_running_functions(std::vector<Function>& out);

}  // namespace polyarm::program
