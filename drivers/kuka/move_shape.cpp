#include "drivers/kuka/move_shape.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::kuka {

using hardware::ForwardMove;

namespace {

constexpr double kLeastAcceleration = 0.01;  // m/s²
constexpr double kLeastBlend = 0.1;          // % of half of the way, or mm

/// $VEL_AXIS and $ACC_AXIS are whole numbers; a robot that is a little slower keeps the limits of the plan.
double percent(double share) {
  return std::clamp(std::floor(100 * share + 1e-3), 1.0, 100.0);
}

/// $APO.CPTP: of half of the way.
double percent_of_way(double blend, double way) {
  const double out = way > 1e-6 ? 200 * blend / way : 0;
  return out < kLeastBlend ? 0 : std::min(out, 100.0);
}

}  // namespace

Six frame_of(const Pose& pose) {
  const Vec3 rpy = to_rpy(pose.rotation);
  return {1000 * pose.position.x, 1000 * pose.position.y, 1000 * pose.position.z,
          rpy.z * wire::kDegrees, rpy.y * wire::kDegrees, rpy.x * wire::kDegrees};
}

Pose pose_of(const Six& f) {
  return {{f[0] / 1000, f[1] / 1000, f[2] / 1000},
          from_rpy(f[5] / wire::kDegrees, f[4] / wire::kDegrees, f[3] / wire::kDegrees)};
}

EkiMove eki_move(const forward::MoveOrder& order, const forward::MoveFrame& frame) {
  EkiMove out;
  const ForwardMove& move = order.move;
  const double blend = forward::blend_of(move, order.from, order.next ? &*order.next : nullptr, frame);
  if (move.kind == ForwardMove::Kind::joint) {
    out.kind = EkiMove::ptp;
    out.end = forward::end_of(move);
    for (double& angle : out.end) angle *= wire::kDegrees;
    out.speed = percent(move.share);
    out.acceleration = percent(move.acceleration);
    out.blend = percent_of_way(blend, forward::joint_way(move, order.from, frame));
    return out;
  }
  const forward::CartesianWay way = forward::cartesian_way(move, order.from, frame);
  const Pose base = inverse(frame.base);
  out.kind = way.arc ? EkiMove::circ : EkiMove::lin;
  out.end = frame_of(base * move.at);
  if (way.arc) out.via = frame_of(base * Pose{move.via.position, move.at.rotation});
  out.speed = way.speed;
  out.acceleration = std::max(move.acceleration * frame.line_acceleration, kLeastAcceleration);
  if (!(way.speed > 0)) out.turn = std::max(way.turn, 1e-3) / std::max(move.duration, 0.01) * wire::kDegrees;
  out.blend = 1000 * blend < kLeastBlend ? 0 : 1000 * blend;
  return out;
}

EkiMove eki_tool(const Pose& T_flange_tcp) {
  EkiMove out;
  out.end = frame_of(T_flange_tcp);
  return out;
}

}  // namespace polyarm::kuka
