#pragma once
/// Why a wait may be in vain, for people.
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

/// What a wait may need.
struct WaitOwners {
  const CellSetup& setup;
  const Machine& machine;
  const CellData& data;
  const Motions& motions;
  const Programs& programs;
};

/// Why a wait for one of these names may be in vain: the feeder is empty or nobody has asked it, the vacuum
/// is off, the gripper is away from every part, the part is too heavy. Empty: nothing is known. Cell thread.
std::string hint_of_wait(const WaitOwners& cell, std::span<const std::string> names);
/// The same for what the program and the PLC wait for now.
std::string hint_of_wait(const WaitOwners& cell);
/// Adds that to a time-out of `task`; leaves other problems as they are.
void explain_timeout(const WaitOwners& cell, const Task& task, Problem& problem);

}  // namespace polyarm::cell
