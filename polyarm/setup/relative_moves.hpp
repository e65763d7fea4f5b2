#pragma once
/// Moves that go by so much from where the robot is.
#include <span>

#include "polyarm/setup/robots.hpp"
#include "polyarm/vm/host.hpp"

namespace polyarm::cell {

/// Does its target say by how much, not where to?
bool is_relative(const program::Move& move);

/// The same move to where it ends: of a line from `here`, the TCP in the move's frame, by lengths x, y, z
/// along the frame's axes and angles rx, ry, rz about them (one rotation, rad); of a joint move from `joints`
/// by what is said of each joint. Throws Error("bad-move", "turn-too-large", "unknown-joint").
program::Move from_here(program::Move move, const data::Point& here, const CellRobot& robot,
                        std::span<const double> joints);

}  // namespace polyarm::cell
