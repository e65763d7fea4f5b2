#pragma once
/// Moves of the runtime as moves of KRL. Any thread; allocates.
#include "drivers/forward/move_queue.hpp"
#include "drivers/kuka/eki.hpp"

namespace polyarm::kuka {

/// X Y Z in mm, A B C in degrees: turns about Z, then the new Y, then the new X.
Six frame_of(const Pose& pose);
Pose pose_of(const Six& frame);

/// Of a move of `order`. Lines and arcs are so slow that no axis exceeds its limit anywhere on them; a blend
/// is less than half of the move and of the next one.
EkiMove eki_move(const forward::MoveOrder& order, const forward::MoveFrame& frame);
/// What sets $TOOL.
EkiMove eki_tool(const Pose& T_flange_tcp);

}  // namespace polyarm::kuka
