#pragma once
/// Where moves go: their paths of joints and the TCP's way on them. Inside the room.
#include <cstddef>
#include <vector>

#include "polyarm/moves/move_parts.hpp"

namespace polyarm::moves {

/// The geometry of the moves `first` to `last`, which belong together, from the joint state `q`; `q` is then
/// where they end. Throws MoveError.
MoveRun move_geometry(const PlanRequest& request, std::size_t first, std::size_t last, std::vector<double>& q,
                      std::vector<MovePlan::Warning>& warnings);

}  // namespace polyarm::moves
