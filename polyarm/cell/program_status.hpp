#pragma once
/// Where the program of a cell is: the one place that says it, for the socket, the pendant and its events. Cell thread.
#include <vector>

#include "polyarm/cell/cell.hpp"
#include "polyarm/protocol/programs.hpp"

namespace polyarm::cell {

protocol::ProgramStatus program_status(const Cell& cell);
/// Of the program or the PLC. `begun`: it was started.
protocol::ProgramOverview program_overview(const Cell& cell, const Task& task, bool begun);

protocol::FileLine file_line(const Location& where);
std::vector<protocol::FileLine> file_lines(const std::vector<Location>& places);
std::vector<protocol::NamedText> named_texts(const std::vector<program::VariableValue>& values);

}  // namespace polyarm::cell
