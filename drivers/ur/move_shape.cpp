#include "drivers/ur/move_shape.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::ur {

using hardware::ForwardMove;

namespace {

constexpr double kLeastSpeed = 1e-3;  // m/s, and rad/s

/// The joints turn together, so the one that turns most sets the speed.
void set_joint_speed(const ForwardMove& move, const Six& from, const MoveFrame& frame, MoveMessage& out) {
  double most = 0;
  for (std::size_t j = 0; j < 6; ++j) most = std::max(most, std::abs(out.goal[j] - from[j]));
  double speed = INFINITY, acceleration = INFINITY;
  for (std::size_t j = 0; j < 6; ++j) {
    const double way = std::abs(out.goal[j] - from[j]);
    const double gear = most > 1e-9 && way > 1e-9 ? most / way : most > 1e-9 ? INFINITY : 1;
    speed = std::min(speed, move.share * frame.velocity[j] * gear);
    acceleration = std::min(acceleration, move.acceleration * frame.acceleration[j] * gear);
  }
  out.speed = std::max(speed, kLeastSpeed);
  out.acceleration = acceleration;
}

}  // namespace

MoveMessage message_of(const ForwardMove& move, const Six& from, const ForwardMove* next,
                       const MoveFrame& frame) {
  MoveMessage out;
  out.goal = forward::end_of(move);
  out.blend = forward::blend_of(move, from, next, frame);
  if (move.kind == ForwardMove::Kind::joint) {
    out.work = Work::joint;
    set_joint_speed(move, from, frame, out);
    return out;
  }
  const forward::CartesianWay way = forward::cartesian_way(move, from, frame);
  out.acceleration = std::max(move.acceleration * frame.line_acceleration, kLeastSpeed);
  out.work = way.arc ? Work::arc : Work::line;
  if (way.arc) out.via = way.via;
  if (way.speed > 0)
    out.speed = way.speed;
  else
    out.time = std::max(move.duration, 0.01);
  return out;
}

MoveMessage tool_message(const Pose& tool) {
  MoveMessage out;
  out.work = Work::tool;
  const Vec3 turn = to_rotation_vector(tool.rotation);
  out.goal = {tool.position.x, tool.position.y, tool.position.z, turn.x, turn.y, turn.z};
  return out;
}

MoveMessage message_of(const MoveOrder& order, const MoveFrame& frame) {
  MoveMessage out;
  if (order.kind == MoveOrder::Kind::halt) out.work = Work::halt;
  if (order.kind == MoveOrder::Kind::tool) out = tool_message(order.tool);
  if (order.kind == MoveOrder::Kind::move)
    out = message_of(order.move, order.from, order.next ? &*order.next : nullptr, frame);
  out.number = order.number;
  return out;
}

}  // namespace polyarm::ur
