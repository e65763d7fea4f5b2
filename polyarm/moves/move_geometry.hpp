#pragma once
/// The geometry of moves: their joint paths and the TCP's way on them. Private to this room. Metres, radians;
/// not for the control cycle.
#include <cstddef>
#include <vector>

#include "polyarm/moves/move_parts.hpp"

namespace polyarm::moves {

/// The geometry of the moves `first` to `last`, which belong together, from the joint state `q`; sets `q` to
/// their end. Throws MoveError.
MoveRun move_geometry(const PlanRequest& request, std::size_t first, std::size_t last, std::vector<double>& q,
                      std::vector<MovePlan::Warning>& warnings);

}  // namespace polyarm::moves
