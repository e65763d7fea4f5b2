#pragma once
/// Moves of the runtime as moves of the controller: speeds, blends, points of arcs. Metres, radians, seconds.
/// Any thread.
#include <memory>

#include "drivers/ur/move_script.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::ur {

/// What the moves of one robot need to know of it.
struct MoveFrame {
  Pose base;                                        ///< T_world_base, of the cell
  std::shared_ptr<const kinematics::Chain> flange;  ///< of the tool flange in the base
  Six velocity{}, acceleration{};                   ///< limits of the joints
  double line_acceleration = 1.2;                   ///< m/s² of lines and arcs
};

/// The TCP in the flange at the end of the move.
Pose tool_of(const hardware::ForwardMove& move, const MoveFrame& frame);
/// Of the TCP, in the base of the description.
Pose tcp_at(const Six& q, const Pose& tool, const MoveFrame& frame);

/// The message of a move that begins at the joints `from`; its number is left open. `next`: the move after
/// it, null without one. Lines and arcs are so slow that no joint exceeds its limit anywhere on them. A blend
/// is less than half of the move and of the next one.
MoveMessage message_of(const hardware::ForwardMove& move, const Six& from, const hardware::ForwardMove* next,
                       const MoveFrame& frame);
/// The message that sets the TCP.
MoveMessage tool_message(const Pose& tool);
/// What is left of an arc that began at the joints `from`, for a robot that stands at `here`: a line if
/// nearly nothing is left.
void shorten_arc(hardware::ForwardMove& arc, const Six& from, const Six& here, const MoveFrame& frame);

}  // namespace polyarm::ur
