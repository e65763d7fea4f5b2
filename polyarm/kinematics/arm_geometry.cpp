#include "polyarm/kinematics/arm_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace polyarm::kinematics {

void ArmGeometry::forward(std::span<const double> values, Rotation& rotation, Vec3& position) const noexcept {
  rotation = tool_rotation;
  position = tool_position;
  for (std::size_t i = count; i-- > 0;) {
    const JointAxis& axis = axes[i];
    if (axis.slides) {
      position = position + values[i] * axis.direction;
      continue;
    }
    const Rotation turn = rotation_about(axis.direction, values[i]);
    rotation = turn * rotation;
    position = axis.point + turn * (position - axis.point);
  }
}

namespace {

/// The vector from a point to its foot on the axis.
Vec3 to_axis(const JointAxis& axis, const Vec3& point) {
  const Vec3 away = axis.point - point;
  return away - dot(away, axis.direction) * axis.direction;
}

}  // namespace

double ArmGeometry::size() const noexcept {
  double sum = 0;
  Vec3 at = axes[0].point;
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3 way = to_axis(axes[i], at);
    sum += norm(way);
    at = at + way;
  }
  return sum + norm(tool_position - at);
}

std::optional<ArmGeometry> geometry_of(const Chain& chain, std::string& why_not) {
  ArmGeometry out;
  std::array<bool, Chain::kMaxJoints> seen{};
  for (const Chain::Axis& axis : chain.axes()) {
    if (seen[axis.joint]) {
      why_not = fmt::format("{} drives more than one joint", chain.names()[axis.joint]);
      return std::nullopt;
    }
    if (std::abs(axis.ratio) != 1.0) {
      why_not = fmt::format("{} is followed at {} times its value", chain.names()[axis.joint], axis.ratio);
      return std::nullopt;
    }
    if (out.count == ArmGeometry::kMostAxes) {
      why_not = fmt::format("there are more than {} joints", ArmGeometry::kMostAxes);
      return std::nullopt;
    }
    seen[axis.joint] = true;
    out.axes[out.count++] = {axis.ratio * axis.direction, axis.point, axis.slides, axis.joint};
  }
  if (out.count == 0) {
    why_not = "no joint moves the tool";
    return std::nullopt;
  }
  const Pose tool = chain.forward(std::vector<double>(chain.joints(), 0.0));
  out.tool_rotation = rotation_of(tool.rotation);
  out.tool_position = tool.position;
  return out;
}

ArmGeometry reversed(const ArmGeometry& arm) noexcept {
  ArmGeometry out;
  out.count = arm.count;
  out.tool_rotation = transposed(arm.tool_rotation);
  out.tool_position = -(out.tool_rotation * arm.tool_position);
  for (std::size_t i = 0; i < arm.count; ++i) {
    JointAxis axis = arm.axes[arm.count - 1 - i];
    axis.direction = -(out.tool_rotation * axis.direction);
    axis.point = out.tool_rotation * (axis.point - arm.tool_position);
    out.axes[i] = axis;
  }
  return out;
}

ArmGeometry locked(const ArmGeometry& arm, std::size_t k, double value) noexcept {
  ArmGeometry out;
  const JointAxis& held = arm.axes[k];
  const Rotation turn = held.slides ? Rotation{} : rotation_about(held.direction, value);
  const Vec3 shift = held.slides ? value * held.direction : held.point - turn * held.point;
  out.tool_rotation = turn * arm.tool_rotation;
  out.tool_position = shift + turn * arm.tool_position;
  for (std::size_t i = 0; i < arm.count; ++i) {
    if (i == k) continue;
    JointAxis axis = arm.axes[i];
    if (i > k) {
      axis.direction = turn * axis.direction;
      axis.point = shift + turn * axis.point;
    }
    out.axes[out.count++] = axis;
  }
  return out;
}

}  // namespace polyarm::kinematics
