#pragma once
/// Planned motions as moves for a robot whose own controller interpolates. Metres, radians, seconds; not for
/// the control cycle. Any thread, while the robot's facts stay valid.
#include <memory>
#include <optional>
#include <span>

#include "polyarm/joint_control/forward_motion.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::moves {

/// Why the move cannot be sent as a move; nothing if it can. `robot`: its name.
std::optional<Problem> refuse_forward(const Move& move, const std::string& robot);

/// A motion of a plan as moves. `moves`: those of the plan, PlannedMotion::first counts from the first of
/// them. `begin`: s of the motion at which the robot stands; moves that end before are left out, and the rest
/// of an arc is an arc. Speeds are the highest that the plan has in the move, and joint moves are so slow
/// that the TCP keeps its own limit and `tcp_ceiling` (m/s; 0: unlimited) everywhere. A blend is at most half
/// of the shorter of its two moves. A move around obstacles is a sequence of joint moves that stop at its
/// corners. Throws Error with the codes of joints_for().
std::unique_ptr<controllers::ForwardMotion> forward_motion(const RobotFacts& robot,
                                                           std::span<const Move> moves,
                                                           const PlannedMotion& motion, double begin = 0,
                                                           double tcp_ceiling = 0);

}  // namespace polyarm::moves
