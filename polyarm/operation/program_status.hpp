#pragma once
/// Status of a cell's program, made in one place for the socket, the pendant and events. Cell thread.
#include <vector>

#include "polyarm/machine/event_log.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

class Jogging;

/// The parts of the cell that a program's status is made from.
struct StatusOwners {
  const CellSetup& setup;
  const Machine& machine;
  const Programs& programs;
  const Jogging& jogging;
  const EventLog& events;
  const CellData& data;
};
protocol::ProgramStatus program_status(const StatusOwners& cell);
/// Overview of the program or the PLC. `begun`: it was started. `data`: its links may still keep it waiting.
protocol::ProgramOverview program_overview(const CellSetup& setup, const Task& task, bool begun,
                                           const CellData& data);

protocol::FileLine file_line(const Location& where);
std::vector<protocol::FileLine> file_lines(const std::vector<Location>& places);
std::vector<protocol::NamedText> named_texts(const std::vector<program::VariableValue>& values);

}  // namespace polyarm::cell
