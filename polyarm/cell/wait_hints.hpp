#pragma once
/// Why a wait may be in vain, for people.
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

class Cell;
class Task;

/// Why a wait for one of these names may be in vain: the feeder is empty or nobody has asked it, the vacuum
/// is off, the gripper is away from every part, the part is too heavy. Empty: nothing is known. Cell thread.
std::string hint_of_wait(Cell& cell, std::span<const std::string> names);
/// The same for what the program and the PLC wait for now.
std::string hint_of_wait(Cell& cell);
/// Adds that to a time-out of `task`; leaves other problems as they are.
void explain_timeout(Cell& cell, const Task& task, Problem& problem);

}  // namespace polyarm::cell
