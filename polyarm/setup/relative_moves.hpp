#pragma once
/// Moves relative to the present position of a robot.
#include <span>

#include "polyarm/setup/robots.hpp"
#include "polyarm/vm/host.hpp"

namespace polyarm::cell {

/// True if the target is a displacement.
bool is_relative(const program::Move& move);

/// Converts a relative move to an absolute one. A line starts at `here`, the TCP in the move's frame, and
/// adds lengths x, y, z along the frame's axes and angles rx, ry, rz about them (one rotation, rad). A joint
/// move adds the given values to `joints`. Throws Error("bad-move", "turn-too-large", "unknown-joint").
program::Move from_here(program::Move move, const data::Point& here, const CellRobot& robot,
                        std::span<const double> joints);

}  // namespace polyarm::cell
