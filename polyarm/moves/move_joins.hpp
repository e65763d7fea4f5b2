#pragma once
/// Blends between moves of different kinds. Inside the room.
#include <vector>

#include "polyarm/moves/move_parts.hpp"

namespace polyarm::moves {

/// Rounds the corner between the last part of the draft and `next`, within the blend of the move before: both
/// give up what lies within, and the draft gets a part more. False where there is no room at all.
bool join_moves(const PlanRequest& request, MoveDraft& draft, MovePart& next,
                std::vector<MovePlan::Warning>& warnings);

}  // namespace polyarm::moves
