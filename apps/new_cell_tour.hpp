#pragma once
/// The cell that `polyarm new cell` writes for an arm that cannot take parts from above: a program that moves
/// the joints around home.
#include <map>
#include <string>

#include "apps/new_cell.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::apps {

/// File names with their texts. Every joint moves by at most `size` times 0.4 rad, or 0.4 of its range.
/// `why`: a sentence in README.md.
std::map<std::string, std::string> tour_files(const NewCell& asked, const cell::CellRobot& robot,
                                              const std::string& hardware, const std::string& why,
                                              double size);

}  // namespace polyarm::apps
