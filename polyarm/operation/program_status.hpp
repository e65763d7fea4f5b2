#pragma once
/// Where the program of a cell is: the one place that says it, for the socket, the pendant and its events. Cell thread.
#include <vector>

#include "polyarm/machine/event_log.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

class Jogging;

/// What the status of a program is made from.
struct StatusOwners {
  const CellSetup& setup;
  const Machine& machine;
  const Programs& programs;
  const Jogging& jogging;
  const EventLog& events;
};
protocol::ProgramStatus program_status(const StatusOwners& cell);
/// Of the program or the PLC. `begun`: it was started.
protocol::ProgramOverview program_overview(const CellSetup& setup, const Task& task, bool begun);

protocol::FileLine file_line(const Location& where);
std::vector<protocol::FileLine> file_lines(const std::vector<Location>& places);
std::vector<protocol::NamedText> named_texts(const std::vector<program::VariableValue>& values);

}  // namespace polyarm::cell
