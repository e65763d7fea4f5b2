#include "drivers/xarm/moves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "drivers/wire/arcs.hpp"
#include "drivers/wire/six_axes.hpp"

namespace polyarm::xarm {

using hardware::ForwardMove;

namespace {

constexpr double kMm = 1000;
// What the maker's client allows.
constexpr double kMostJointSpeed = std::numbers::pi, kMostJointAcceleration = 20;  // rad, s
constexpr double kMostSpeed = 1000, kMostAcceleration = 50'000;                    // mm, s
constexpr double kLeastJointSpeed = 1e-3, kLeastSpeed = 0.1;
constexpr std::size_t kFloat = 4;
constexpr std::size_t kGeneralLine = 10, kCircle = 16, kGeneralBytes = 3;

UxData with_forms(UxData data, bool general) {
  if (general) data.u8(0).u8(0).u8(0);  // base coordinates, no axis with an angle, not only a check
  return data;
}

/// The bytes of the general form behind `floats` floats: only those of with_forms() are taken.
bool plain(Bytes data, std::size_t floats) {
  const Bytes bytes = data.subspan(floats * kFloat);
  return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; });
}

/// Through `via`, up to the end of the arc.
double percent_of(const ForwardMove& move, const Pose& begin, const forward::MoveFrame& frame) {
  const Pose base = inverse(frame.base);
  const Vec3 end = (base * move.at).position;
  const auto circle = wire::Circle::through(begin.position, (base * move.via).position, end);
  return circle ? 100 * circle->angle_of(end) / (2 * std::numbers::pi) : 100;
}

}  // namespace

UxMoveForms forms_of(const Version& version) {
  const auto now = std::tuple(version.major, version.minor, version.revision);
  return {now >= std::tuple(1, 5, 20), now >= std::tuple(1, 11, 100)};
}

UxMoveRequest encode(const UxMove& move, const UxMoveForms& forms) {
  const bool rounds = move.radius >= 0;
  switch (move.kind) {
    case UxMove::Kind::joint: {
      const bool blends = rounds && forms.joint_radius;
      const Register reg = blends ? Register::move_joint_blend : Register::move_joint;
      return {reg,
              UxData().f32(move.joints).f32(move.speed).f32(move.acceleration).f32(blends ? move.radius : 0)};
    }
    case UxMove::Kind::line: {
      UxData data = UxData().f32(move.pose).f32(move.speed).f32(move.acceleration).f32(0);
      if (forms.general) return {Register::move_line, with_forms(data.f32(rounds ? move.radius : -1), true)};
      if (!rounds) return {Register::move_line, data};
      return {Register::move_line_blend, data.f32(move.radius)};
    }
    case UxMove::Kind::circle: {
      UxData data = UxData().f32(move.via).f32(move.pose).f32(move.speed).f32(move.acceleration);
      return {Register::move_circle, with_forms(data.f32(0).f32(move.percent), forms.general)};
    }
  }
  return {};
}

std::optional<UxMove> decode_move(Register reg, Bytes data) {
  UxMove out;
  const auto take = [&](std::size_t count) { return floats(data, count); };
  const auto fill = [](auto& into, const std::vector<double>& from, std::size_t at) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(at), into.size(), into.begin());
  };
  switch (reg) {
    case Register::move_home:
    case Register::move_joint:
    case Register::move_joint_blend: {
      const std::size_t joints = reg == Register::move_home ? 0 : kWireJoints;
      const auto values = take(joints + 3);
      if (!values || !plain(data, joints + 3)) return std::nullopt;
      if (joints > 0) fill(out.joints, *values, 0);
      out.speed = (*values)[joints];
      out.acceleration = (*values)[joints + 1];
      if (reg == Register::move_joint_blend) out.radius = (*values)[joints + 2];
      return out;
    }
    case Register::move_line:
    case Register::move_line_blend: {
      const bool general = data.size() >= kGeneralLine * kFloat + kGeneralBytes;
      const std::size_t count = general || reg == Register::move_line_blend ? kGeneralLine : kGeneralLine - 1;
      const auto values = take(count);
      if (!values || !plain(data, count)) return std::nullopt;
      out.kind = UxMove::Kind::line;
      fill(out.pose, *values, 0);
      out.speed = (*values)[6];
      out.acceleration = (*values)[7];
      if (count == kGeneralLine) out.radius = (*values)[9];
      return out;
    }
    case Register::move_circle: {
      const auto values = take(kCircle);
      if (!values || !plain(data, kCircle)) return std::nullopt;
      out.kind = UxMove::Kind::circle;
      fill(out.via, *values, 0);
      fill(out.pose, *values, 6);
      out.speed = (*values)[12];
      out.acceleration = (*values)[13];
      out.percent = (*values)[15];
      return out;
    }
    default:
      return std::nullopt;
  }
}

Six pose_values(const Pose& pose) {
  const Vec3 rpy = to_rpy(pose.rotation);
  return {kMm * pose.position.x, kMm * pose.position.y, kMm * pose.position.z, rpy.x, rpy.y, rpy.z};
}

Pose pose_from(const Six& values) {
  return {{values[0] / kMm, values[1] / kMm, values[2] / kMm}, from_rpy(values[3], values[4], values[5])};
}

UxMove ux_move(const forward::MoveOrder& order, const forward::MoveFrame& frame) {
  UxMove out;
  const ForwardMove& move = order.move;
  const double blend = forward::blend_of(move, order.from, order.next ? &*order.next : nullptr, frame);
  const bool before_arc = order.next && order.next->kind == ForwardMove::Kind::arc;
  if (blend > 0 && !before_arc) out.radius = kMm * blend;
  if (move.kind == ForwardMove::Kind::joint) {
    std::copy_n(move.joints.begin(), 6, out.joints.begin());
    const forward::JointSpeeds speeds = forward::joint_speeds(move, order.from, frame);
    out.speed = std::clamp(order.pace * speeds.speed, kLeastJointSpeed, kMostJointSpeed);
    out.acceleration = std::clamp(speeds.acceleration, kLeastJointSpeed, kMostJointAcceleration);
    return out;
  }
  const forward::CartesianWay way = forward::cartesian_way(move, order.from, frame);
  const Pose base = inverse(frame.base);
  out.kind = way.arc ? UxMove::Kind::circle : UxMove::Kind::line;
  out.pose = pose_values(base * move.at);
  if (way.arc) {
    const Pose begin = forward::tcp_at(order.from, forward::tool_of(move, frame), frame);
    out.via = pose_values(base * Pose{move.via.position, move.at.rotation});
    out.percent = percent_of(move, begin, frame);
    out.radius = -1;
  }
  const double speed =
      way.speed > 0 ? kMm * way.speed : wire::kDegrees * way.turn / std::max(move.duration, 0.01);
  out.speed = std::clamp(order.pace * speed, kLeastSpeed, kMostSpeed);
  out.acceleration =
      std::clamp(kMm * move.acceleration * frame.line_acceleration, kLeastSpeed, kMostAcceleration);
  return out;
}

}  // namespace polyarm::xarm
