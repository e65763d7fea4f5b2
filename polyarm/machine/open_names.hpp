#pragma once
/// Finds the names of a cell whose values may change independently of its program.
#include <set>
#include <string>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

class CellData;

/// All names that the program sets.
std::set<std::string> names_set(const program::Program& program);
/// All names of the cell that the hardware, a camera, a link, a file written by others, or the program
/// `others` may change while the cell runs; also points in such frames and points on a robot. Cell thread.
std::set<std::string> open_names(const CellData& data, const program::Program* others);

}  // namespace polyarm::cell
