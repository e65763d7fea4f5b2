#pragma once
/// Looks along the moves of a program before anything moves.
#include <cstddef>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

class Cell;

struct Rehearsal {
  Problems problems;      ///< of moves that cannot be made, each at its line
  std::size_t moves = 0;  ///< that were planned
  Location reached;       ///< where the program could not be followed any further; empty: to its end
};

/// Goes through the program of a cell that has not begun, without time and robots: moves are planned one
/// after the other from where those before them end and count as made; loops of the program are passed twice;
/// a wait for tags is helped by turning booleans over that it reads, and what is found after the first such
/// help is a warning, since the program may never come there so. Changes the cell's values: it is of no use
/// for running afterwards. Cell thread.
Rehearsal rehearse(Cell& cell);

}  // namespace polyarm::cell
