#pragma once
/// Looks along the moves of a program before anything moves.
#include <cstddef>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::cell {

class Cell;

/// The way of the TCP in one motion from rest to rest, in the world.
struct RehearsedPath {
  std::string robot;
  Location where;         ///< of its first move
  double seconds = 0;     ///< it takes
  std::vector<Vec3> tcp;  ///< m, from its start to its end
};

struct Rehearsal {
  Problems problems;      ///< of moves that cannot be made, each at its line
  std::size_t moves = 0;  ///< that were planned
  Location reached;       ///< where the program could not be followed any further; empty: to its end
  std::vector<RehearsedPath> paths;  ///< where they were asked for
};

/// Goes through the program of a cell that has not begun, without time and robots: moves are planned one
/// after the other from where those before them end and count as made; loops of the program are passed twice;
/// a wait for tags is helped by turning booleans over that it reads, and what is found after the first such
/// help is a warning, since the program may never come there so. Changes the cell's values: it is of no use
/// for running afterwards. Cell thread. `with_paths`: the ways are kept, too.
Rehearsal rehearse(Cell& cell, bool with_paths = false);

}  // namespace polyarm::cell
