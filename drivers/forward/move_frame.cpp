#include "drivers/forward/move_frame.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "drivers/forward/near_joints.hpp"
#include "drivers/wire/arcs.hpp"

namespace polyarm::forward {

using hardware::ForwardMove;
using wire::between;
using wire::Circle;

namespace {

constexpr int kPlaces = 16;             // of a line at which its speed is checked
constexpr double kShareOfBlend = 0.49;  // of a move: blends that overlap are refused by controllers
constexpr double kLeastBlend = 1e-3;    // m
constexpr double kMargin = 0.95;        // of the joints' limits, on lines
constexpr double kLeastArc = 0.08;      // rad; controllers refuse arcs whose points are near each other
constexpr double kLeastSpeed = 1e-3;    // m/s

std::optional<Six> joints_at(const Pose& tcp, const Pose& tool, const Six& seed, const MoveFrame& frame) {
  const auto jacobian = [&](const Six& q, std::array<double, 36>& J) { return frame.flange->jacobian(q, J); };
  return near_joints(jacobian, tcp * inverse(tool), seed);
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

int tool_flange(const description::RobotModel& model, int otherwise) {
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == "tool0") return static_cast<int>(i);
  return otherwise;
}

MoveFrame frame_of(const hardware::RobotInstance& robot,
                   const std::array<const description::Joint*, 6>& joints, double line_acceleration) {
  constexpr double kVelocity = 1, kAcceleration = 10;  // rad/s and rad/s²
  MoveFrame out;
  out.base = robot.base;
  out.flange = std::make_shared<const kinematics::Chain>(
      *robot.model, tool_flange(*robot.model, joints.back()->child_link));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    out.velocity[i] = joints[i]->limits.velocity.value_or(kVelocity);
    out.acceleration[i] = joints[i]->limits.acceleration.value_or(kAcceleration);
  }
  out.line_acceleration = line_acceleration;
  return out;
}

Pose tool_of(const ForwardMove& move, const MoveFrame& frame) {
  return inverse(frame.flange->forward(end_of(move))) * inverse(frame.base) * move.at;
}

Pose tcp_at(const Six& q, const Pose& tool, const MoveFrame& frame) {
  return frame.flange->forward(q) * tool;
}

double blend_of(const ForwardMove& move, const Six& from, const ForwardMove* next, const MoveFrame& frame) {
  if (move.stops || !next) return 0;
  const Pose tool = tool_of(move, frame);
  const double way = norm(tcp_at(end_of(move), tool, frame).position - tcp_at(from, tool, frame).position);
  const double ahead = norm(next->at.position - move.at.position);
  const double blend = std::min(move.blend, kShareOfBlend * std::min(way, ahead));
  return blend < kLeastBlend ? 0 : blend;
}

CartesianWay cartesian_way(const ForwardMove& move, const Six& from, const MoveFrame& frame) {
  CartesianWay out;
  const Pose tool = tool_of(move, frame);
  const Pose begin = tcp_at(from, tool, frame), end = tcp_at(end_of(move), tool, frame);
  out.turn = angle_between(begin.rotation, end.rotation);
  if (move.kind == ForwardMove::Kind::arc) {
    const Vec3 via = (inverse(frame.base) * move.via).position;
    const auto circle = Circle::through(begin.position, via, end.position);
    const double whole = circle ? circle->angle_of(end.position) : 0;
    const auto arc = [&](double share) {
      return Pose{circle->point(share * whole), between(begin.rotation, end.rotation, share)};
    };
    const auto by = circle ? joints_at(arc(circle->angle_of(via) / whole), tool, from, frame) : std::nullopt;
    if (by) {
      out.arc = true;
      out.via = *by;
      out.angle = whole;
      out.middle = circle->point(whole / 2);
      out.speed = std::max(kLeastSpeed, std::min(move.speed, steady_speed(arc, tool, from, frame)));
      return out;
    }
  }
  const auto line = [&](double share) {
    return Pose{begin.position + share * (end.position - begin.position),
                between(begin.rotation, end.rotation, share)};
  };
  if (move.speed > 0)
    out.speed = std::max(kLeastSpeed, std::min(move.speed, steady_speed(line, tool, from, frame)));
  return out;
}

JointSpeeds joint_speeds(const ForwardMove& move, const Six& from, const MoveFrame& frame) {
  const Six to = end_of(move);
  const double most = largest_difference(to, from);
  JointSpeeds out{INFINITY, INFINITY};
  for (std::size_t j = 0; j < 6; ++j) {
    const double way = std::abs(to[j] - from[j]);
    const double gear = most > 1e-9 && way > 1e-9 ? most / way : most > 1e-9 ? INFINITY : 1;
    out.speed = std::min(out.speed, move.share * frame.velocity[j] * gear);
    out.acceleration = std::min(out.acceleration, move.acceleration * frame.acceleration[j] * gear);
  }
  return out;
}

double joint_way(const ForwardMove& move, const Six& from, const MoveFrame& frame) {
  const Pose tool = tool_of(move, frame);
  const Six to = end_of(move);
  Vec3 before = tcp_at(from, tool, frame).position;
  double out = 0;
  for (int k = 1; k <= kPlaces; ++k) {
    Six q;
    for (std::size_t j = 0; j < 6; ++j) q[j] = from[j] + k * (to[j] - from[j]) / kPlaces;
    const Vec3 at = tcp_at(q, tool, frame).position;
    out += norm(at - before);
    before = at;
  }
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

}  // namespace polyarm::forward
