#include "drivers/ur/move_shape.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::ur {

using hardware::ForwardMove;

namespace {

constexpr double kLeastSpeed = 1e-3;  // m/s, and rad/s

}  // namespace

MoveMessage message_of(const ForwardMove& move, const Six& from, const ForwardMove* next,
                       const MoveFrame& frame) {
  MoveMessage out;
  out.goal = forward::end_of(move);
  out.blend = forward::blend_of(move, from, next, frame);
  if (move.kind == ForwardMove::Kind::joint) {
    out.work = Work::joint;
    const forward::JointSpeeds speeds = forward::joint_speeds(move, from, frame);
    out.speed = std::max(speeds.speed, kLeastSpeed);
    out.acceleration = speeds.acceleration;
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
