#pragma once
/// Looks along the moves of a program before anything moves.
#include <cstddef>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::cell {

struct CellInside;

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
  std::size_t variants = 0;          ///< of values, answers, time-outs and errors that were tried
  std::size_t left_out = 0;          ///< others that were not tried, because they were too many
};

/// Goes through the program of a cell that has not begun, without time and robots. Moves are planned one
/// after the other, each from the end of the one before, and count as made. Loops of the program are passed
/// twice. Values that end them are set for waits; the cell has its own values again afterwards. Then it goes
/// through again, a bounded number of times: with other values of names that others set, with other answers
/// to questions, with waits that time out, and with errors in each `try`. Cell thread.
///
/// A problem behind such a wait is an error if it is there whatever the wait brings: neither the values of
/// the line nor the place where its move begins depend on what others set. Else it is a warning.
/// `with_paths`: the ways are kept, too.
Rehearsal rehearse(CellInside& cell, bool with_paths = false);
/// The same with the script of the PLC, which moves nothing.
Rehearsal rehearse_plc(CellInside& cell);

}  // namespace polyarm::cell
