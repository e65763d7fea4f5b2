#include "drivers/ur/move_shape.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "drivers/ur/near_joints.hpp"
#include "drivers/wire/arcs.hpp"

namespace polyarm::ur {

using wire::between;
using wire::Circle;

using hardware::ForwardMove;

namespace {

constexpr int kPlaces = 16;             // of a line at which its speed is checked
constexpr double kShareOfBlend = 0.49;  // of a move: blends that overlap are refused by the controller
constexpr double kLeastBlend = 1e-3;    // m
constexpr double kMargin = 0.95;        // of the joints' limits, on lines
constexpr double kLeastArc = 0.02;      // rad
constexpr double kLeastSpeed = 1e-3;    // m/s, and rad/s

Six end_of(const ForwardMove& move) {
  Six out;
  std::copy_n(move.joints.begin(), 6, out.begin());
  return out;
}

std::optional<Six> joints_at(const Pose& tcp, const Pose& tool, const Six& seed, const MoveFrame& frame) {
  const auto jacobian = [&](const Six& q, std::array<double, 36>& J) { return frame.flange->jacobian(q, J); };
  return near_joints(jacobian, tcp * inverse(tool), seed);
}

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

/// The speed of the TCP at which no joint exceeds its limit, at `kPlaces` places of the path.
template <typename Path>
double steady_speed(const Path& path, const Pose& tool, Six q, const MoveFrame& frame) {
  double least = INFINITY;
  Vec3 before = path(0.0).position;
  for (int k = 1; k <= kPlaces; ++k) {
    const Pose at = path(static_cast<double>(k) / kPlaces);
    const std::optional<Six> next = joints_at(at, tool, q, frame);
    if (!next) return least;
    double turned = 0;  // s, at the full speed of the joints
    for (std::size_t j = 0; j < 6; ++j)
      turned = std::max(turned, std::abs((*next)[j] - q[j]) / frame.velocity[j]);
    const double way = norm(at.position - before);
    if (turned > 1e-9 && way > 1e-9) least = std::min(least, kMargin * way / turned);
    before = at.position;
    q = *next;
  }
  return least;
}

}  // namespace

Pose tool_of(const ForwardMove& move, const MoveFrame& frame) {
  return inverse(frame.flange->forward(end_of(move))) * inverse(frame.base) * move.at;
}

Pose tcp_at(const Six& q, const Pose& tool, const MoveFrame& frame) {
  return frame.flange->forward(q) * tool;
}

MoveMessage message_of(const ForwardMove& move, const Six& from, const ForwardMove* next,
                       const MoveFrame& frame) {
  MoveMessage out;
  out.goal = end_of(move);
  const Pose tool = tool_of(move, frame);
  const Pose begin = tcp_at(from, tool, frame), end = tcp_at(out.goal, tool, frame);
  if (!move.stops && next) {
    const double way = norm(end.position - begin.position),
                 ahead = norm(next->at.position - move.at.position);
    out.blend = std::min(move.blend, kShareOfBlend * std::min(way, ahead));
    if (out.blend < kLeastBlend) out.blend = 0;
  }
  if (move.kind == ForwardMove::Kind::joint) {
    out.work = Work::joint;
    set_joint_speed(move, from, frame, out);
    return out;
  }
  out.acceleration = std::max(move.acceleration * frame.line_acceleration, kLeastSpeed);
  const auto line = [&](double share) {
    return Pose{begin.position + share * (end.position - begin.position),
                between(begin.rotation, end.rotation, share)};
  };
  out.work = Work::line;
  if (move.kind == ForwardMove::Kind::arc) {
    const Vec3 via = (inverse(frame.base) * move.via).position;
    const auto circle = Circle::through(begin.position, via, end.position);
    const double whole = circle ? circle->angle_of(end.position) : 0;
    const auto arc = [&](double share) {
      return Pose{circle->point(share * whole), between(begin.rotation, end.rotation, share)};
    };
    const auto by = circle ? joints_at(arc(circle->angle_of(via) / whole), tool, from, frame) : std::nullopt;
    if (by) {
      out.work = Work::arc;
      out.via = *by;
      out.speed = std::max(kLeastSpeed, std::min(move.speed, steady_speed(arc, tool, from, frame)));
      return out;
    }
  }
  if (move.speed > 0)
    out.speed = std::max(kLeastSpeed, std::min(move.speed, steady_speed(line, tool, from, frame)));
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

void shorten_arc(ForwardMove& arc, const Six& from, const Six& here, const MoveFrame& frame) {
  const Pose tool = tool_of(arc, frame);
  const Vec3 end = tcp_at(end_of(arc), tool, frame).position;
  const auto circle =
      Circle::through(tcp_at(from, tool, frame).position, (inverse(frame.base) * arc.via).position, end);
  const double whole = circle ? circle->angle_of(end) : 0;
  double done = circle ? circle->angle_of(tcp_at(here, tool, frame).position) : 0;
  if (done > (whole + 2 * M_PI) / 2) done = 0;  // just before its beginning
  if (!circle || whole - done < kLeastArc) {
    arc.kind = ForwardMove::Kind::line;
    return;
  }
  arc.via.position = (frame.base * Pose{circle->point((done + whole) / 2), {}}).position;
}

}  // namespace polyarm::ur
