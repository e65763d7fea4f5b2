#pragma once
/// `teleop` of a cell file: which robots lead which.
#include <vector>

#include "polyarm/teleop/settings.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

/// `teleop: {NAME: {leader, follower, …}}`. `robots`: the names of the cell's robots.
std::vector<teleop::PairSettings> read_teleop(const Yaml& yaml, const std::vector<std::string>& robots,
                                              Problems& problems);

}  // namespace polyarm::cell
