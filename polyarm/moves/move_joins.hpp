#pragma once
/// Blends between moves of different kinds. Private to this room; not for the control cycle.
#include <vector>

#include "polyarm/moves/move_parts.hpp"

namespace polyarm::moves {

/// Rounds the corner between the last part of the draft and `next`, within the blend of the previous move:
/// both are shortened, and the draft gets an additional part. False if there is no room.
bool join_moves(const PlanRequest& request, MoveDraft& draft, MovePart& next,
                std::vector<MovePlan::Warning>& warnings);

}  // namespace polyarm::moves
