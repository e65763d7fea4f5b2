#pragma once
/// The names of a cell whose values others than its program change.
#include <set>
#include <string>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

class CellData;

/// Every name that lines of the program set.
std::set<std::string> names_set(const program::Program& program);
/// Every name of the cell that the hardware, a camera, a link, a file that others write, or a program of
/// `others` changes while the cell runs; and points in frames that do, or that are on a robot. Cell thread.
std::set<std::string> open_names(const CellData& data, const program::Program* others);

}  // namespace polyarm::cell
