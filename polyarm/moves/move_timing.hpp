#pragma once
/// When moves are where: what bounds their paths, and the time on them. Inside the room.
#include <span>

#include "polyarm/moves/move_parts.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::moves {

/// The parts of a draft as one motion from rest to rest, within `limits` of the joints, what the moves say,
/// the workspace and the torques. Throws MoveError.
PlannedMotion time_moves(const PlanRequest& request, const MoveDraft& draft,
                         std::span<const trajectory::MotionLimits> limits);

}  // namespace polyarm::moves
