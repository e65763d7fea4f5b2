#pragma once
/// The timing of moves: the bounds of their paths and the resulting time. Private to this room; not for the
/// control cycle.
#include <span>

#include "polyarm/moves/move_parts.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::moves {

/// The parts of a draft as one motion from rest to rest, within `limits` of the joints, the bounds of the
/// moves, the workspace and the torques. Throws MoveError.
PlannedMotion time_moves(const PlanRequest& request, const MoveDraft& draft,
                         std::span<const trajectory::MotionLimits> limits);

}  // namespace polyarm::moves
