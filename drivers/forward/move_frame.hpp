#pragma once
/// Moves of the runtime in the terms of a controller with six axes: tool, speeds that no joint exceeds,
/// blends, points of arcs. Metres, radians, seconds. Any thread; allocates.
#include <array>
#include <memory>
#include <string>

#include "drivers/forward/move_buffer.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::forward {

/// What the moves of one robot need to know of it.
struct MoveFrame {
  Pose base;                                        ///< T_world_base, of the cell
  std::shared_ptr<const kinematics::Chain> flange;  ///< of the tool flange in the base
  Six velocity{}, acceleration{};                   ///< limits of the joints
  double line_acceleration = 1.2;                   ///< m/s² of lines and arcs
};
/// The link of the controller's tool flange, with its z axis out of the flange; `otherwise` if the model has
/// none.
int tool_flange(const description::RobotModel& model, int otherwise);
/// Of a robot with these joints. 1 rad/s and 10 rad/s² stand for limits that the description does not state.
MoveFrame frame_of(const hardware::RobotInstance& robot,
                   const std::array<const description::Joint*, 6>& joints, double line_acceleration);

/// The TCP in the flange at the end of the move.
Pose tool_of(const hardware::ForwardMove& move, const MoveFrame& frame);
/// Of the TCP, in the base of the description.
Pose tcp_at(const Six& q, const Pose& tool, const MoveFrame& frame);
/// m, of a blend between two moves: less than half of the straight way of each. 0 without a next move, and
/// for a move that stops.
double blend_of(const hardware::ForwardMove& move, const Six& from, const hardware::ForwardMove* next,
                const MoveFrame& frame);

/// A line or an arc as the controller makes it.
struct CartesianWay {
  bool arc = false;  ///< also false for an arc whose points are on one line or out of reach
  Six via{};         ///< joints at the point on the way of an arc
  double angle = 0;  ///< rad, of an arc
  Vec3 middle;       ///< of an arc, half way to its end; in the base of the description
  double speed = 0;  ///< m/s, at which no joint exceeds its limit anywhere; 0: the TCP only turns
  double turn = 0;   ///< rad, of the TCP
};
/// Of a move that begins at the joints `from`.
CartesianWay cartesian_way(const hardware::ForwardMove& move, const Six& from, const MoveFrame& frame);
/// Of the joint that turns most in a joint move: the joints turn together, and none exceeds its limit.
struct JointSpeeds {
  double speed = 0, acceleration = 0;  ///< rad/s and rad/s²
};
JointSpeeds joint_speeds(const hardware::ForwardMove& move, const Six& from, const MoveFrame& frame);
/// m that the TCP travels in a joint move.
double joint_way(const hardware::ForwardMove& move, const Six& from, const MoveFrame& frame);

/// What is left of an arc that began at the joints `from`, for a robot that stands at `here`: a line if
/// nearly nothing is left.
void shorten_arc(hardware::ForwardMove& arc, const Six& from, const Six& here, const MoveFrame& frame);

}  // namespace polyarm::forward
