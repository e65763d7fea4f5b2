#pragma once
/// Plans the moves of a program before anything moves, and reports those that cannot be made.
#include <cstddef>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::cell {

struct CellInside;

/// Path of the TCP in one motion from rest to rest, world frame.
struct RehearsedPath {
  std::string robot;
  Location where;         ///< of the first move
  double seconds = 0;     ///< duration
  std::vector<Vec3> tcp;  ///< positions from start to end, m
};

struct Rehearsal {
  Problems problems;      ///< of moves that cannot be made, each with its line
  std::size_t moves = 0;  ///< number of planned moves
  Location reached;       ///< where the program could not be followed further; empty: followed to the end
  std::vector<RehearsedPath> paths;  ///< filled only if paths were requested
  std::size_t variants = 0;          ///< number of values, answers, timeouts and errors tried
  std::size_t left_out = 0;          ///< number not tried because of the limit
};

/// Rehearses the program of a cell that has not started; needs no time and no robots. Each move is planned
/// from the end of the move before and counts as made. The main loop is passed twice, or more often if its
/// condition, or that of a `break`, compares. Waits are ended by setting values; afterwards the cell's values
/// are restored. Then the rehearsal repeats, a bounded number of times, with other values of names that
/// others set, other answers to questions, waits that time out, each `until` that ends otherwise, and errors
/// in each `try`. Cell thread.
///
/// A problem after such a wait is an error if it occurs for every outcome of the wait: neither the values of
/// its line nor the start of its move depend on what others set. Otherwise it is a warning. `with_paths` also
/// keeps the TCP paths.
Rehearsal rehearse(CellInside& cell, bool with_paths = false);
/// The same for the PLC script, which moves nothing.
Rehearsal rehearse_plc(CellInside& cell);

}  // namespace polyarm::cell
