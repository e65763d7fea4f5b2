#pragma once
/// Which joints a controller of a base drives, from its parameters alone. Any thread.
#include <string>
#include <vector>

#include "polyarm/controllers/parameters.hpp"

namespace polyarm::controllers {

/// The joints of wheels and of steering that the parameters name, as written, in the names of all controllers
/// of bases and of all their generations; empty for the parameters of other controllers. Does not declare or
/// check anything.
std::vector<std::string> wheel_names(const Parameters& parameters);

}  // namespace polyarm::controllers
