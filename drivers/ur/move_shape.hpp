#pragma once
/// Moves of the runtime as messages to the program on the robot. Metres, radians, seconds. Any thread.
#include "drivers/forward/move_frame.hpp"
#include "drivers/forward/move_queue.hpp"
#include "drivers/ur/move_script.hpp"

namespace polyarm::ur {

using forward::MoveFrame;
using forward::MoveOrder;
using forward::MoveQueue;
using forward::MoveReport;

/// The message of a move that begins at the joints `from`; its number is left open. `next`: the move after
/// it, null without one. Lines and arcs are so slow that no joint exceeds its limit anywhere on them. A blend
/// is less than half of the move and of the next one.
MoveMessage message_of(const hardware::ForwardMove& move, const Six& from, const hardware::ForwardMove* next,
                       const MoveFrame& frame);
/// The message that sets the TCP.
MoveMessage tool_message(const Pose& tool);
/// The message of what is to be sent; its sequence and time-out are left open.
MoveMessage message_of(const MoveOrder& order, const MoveFrame& frame);

}  // namespace polyarm::ur
