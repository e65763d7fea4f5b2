#pragma once
/// Hints for people: why a wait may never end.
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

class CellData;
class Machine;
class Motions;
class Programs;
class Task;
struct CellSetup;

/// The parts of the cell that hints need.
struct WaitOwners {
  const CellSetup& setup;
  const Machine& machine;
  const CellData& data;
  const Motions& motions;
  const Programs& programs;
};

/// Why a wait for one of these names may never end: the feeder is empty or was not triggered, the vacuum is
/// off, the gripper is far from every part, the part is too heavy. Empty if no reason is known. Cell thread.
std::string hint_of_wait(const WaitOwners& cell, std::span<const std::string> names);
/// The same for the present waits of the program and the PLC.
std::string hint_of_wait(const WaitOwners& cell);
/// Adds the hint to a timeout of `task`; does not change other problems.
void explain_timeout(const WaitOwners& cell, const Task& task, Problem& problem);

}  // namespace polyarm::cell
