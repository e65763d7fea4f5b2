#include "polyarm/closed_form/sliding_arm.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::kinematics {

namespace {

double angle_about(const Vec3& h, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 a = cross(h, from), b = cross(h, to);
  return std::atan2(dot(h, cross(a, b)), dot(a, b));
}

double determinant(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  return dot(a, cross(b, c));
}

bool all_parallel(const ArmGeometry& arm) noexcept {
  for (std::size_t i = 1; i < arm.count; ++i)
    if (norm(cross(arm.axes[0].direction, arm.axes[i].direction)) > kLooseTolerance) return false;
  return true;
}

bool apart(const JointAxis& a, const JointAxis& b, double least) noexcept {
  return norm(cross(a.direction, b.point - a.point)) > least;
}

}  // namespace

SlidingArm::Kind SlidingArm::kind_of(const ArmGeometry& arm) noexcept {
  std::array<const JointAxis*, 3> turning{};
  std::size_t turns = 0;
  for (std::size_t i = 0; i < arm.count; ++i) {
    if (arm.axes[i].slides) continue;
    if (turns < 3) turning[turns] = &arm.axes[i];
    ++turns;
  }
  const double least = kLooseTolerance * arm.size();
  if (arm.count == 4 && turns == 3 && all_parallel(arm) && apart(*turning[0], *turning[1], least) &&
      apart(*turning[1], *turning[2], least))
    return Kind::scara;
  const bool slides_first = arm.count >= 4 && arm.axes[0].slides && arm.axes[1].slides && arm.axes[2].slides;
  if (!slides_first || arm.count > 6 || turns != arm.count - 3) return Kind::none;
  for (std::size_t i = 4; i < arm.count; ++i)
    if (norm(cross(arm.axes[i - 1].direction, arm.axes[i].direction)) < 0.02) return Kind::none;
  const double volume = determinant(arm.axes[0].direction, arm.axes[1].direction, arm.axes[2].direction);
  return std::abs(volume) > 0.02 ? Kind::gantry : Kind::none;
}

SlidingArm::SlidingArm(const ArmGeometry& arm, Kind kind) noexcept : arm_(&arm), kind_(kind) {
  if (kind != Kind::scara) return;
  std::size_t turns = 0;
  for (std::size_t i = 0; i < arm.count; ++i)
    if (arm.axes[i].slides)
      sliding_ = i;
    else
      turning_[turns++] = i;
  const Vec3& z = arm.axes[turning_[0]].direction;
  for (std::size_t k = 0; k < 3; ++k) sign_[k] = dot(z, arm.axes[turning_[k]].direction) < 0 ? -1 : 1;
}

/// Two links in the plane, then the remaining rotation, then the height.
void SlidingArm::solve_scara(const PoseTarget& target, const double* seed, double side,
                             State& out) const noexcept {
  const auto axis = [&](std::size_t k) -> const JointAxis& { return arm_->axes[turning_[k]]; };
  const Vec3 z = axis(0).direction;
  const auto flat = [&](const Vec3& v) { return v - dot(z, v) * z; };
  const Rotation turn = target.rotation * transposed(arm_->tool_rotation);
  const Vec3 any = std::abs(z.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0}, beside = normalized(cross(z, any));
  const double whole = angle_about(z, beside, turn * beside);
  const Vec3 first = flat(axis(1).point - axis(0).point), second = flat(axis(2).point - axis(1).point);
  const Vec3 last = rotation_about(z, whole) * (arm_->tool_position - axis(2).point);
  const Vec3 reach = flat(target.position - axis(0).point - last);
  const double c = dot(first, second), s = dot(first, cross(z, second));
  const double wanted = 0.5 * (dot(reach, reach) - dot(first, first) - dot(second, second));
  const double b = std::atan2(s, c) + side * std::acos(std::clamp(wanted / std::hypot(s, c), -1.0, 1.0));
  const Vec3 link = first + rotation_about(z, b) * second;
  const bool folded = norm(link) < 1e-10 * arm_->size() || norm(reach) < 1e-10 * arm_->size();
  const double a = folded ? seed[turning_[0]] : angle_about(z, link, reach);
  out[turning_[0]] = a;
  out[turning_[1]] = sign_[1] * b;
  out[turning_[2]] = sign_[2] * (whole - a - b);
  const Vec3 way = arm_->axes[sliding_].direction;
  out[sliding_] = dot(z, target.position - arm_->tool_position) / dot(z, way);
}

/// As near to the orientation as up to three turning axes can come.
void SlidingArm::turn_wrist(const Rotation& turn, const double* seed, double side,
                            State& out) const noexcept {
  const auto h = [&](std::size_t k) { return arm_->axes[2 + k].direction; };
  const std::size_t last = arm_->count - 3;
  const Vec3 end = h(last), any = std::abs(end.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  const Vec3 beside = normalized(cross(end, any));
  Vec3 seen = turn * beside;
  const auto undo = [&](std::size_t k) { seen = rotation_about(h(k), -out[2 + k]) * seen; };
  if (last == 3) {
    const Vec3 u = turn * end;
    const double bc = dot(h(2), end), ab = dot(h(1), h(2));
    const double s = dot(h(1), cross(h(2), end)), c = dot(h(1), end) - ab * bc;
    const double wanted = dot(h(1), u) - ab * bc;
    out[4] = std::atan2(s, c) + side * std::acos(std::clamp(wanted / std::hypot(s, c), -1.0, 1.0));
    const Vec3 bent = rotation_about(h(2), out[4]) * end;
    const bool singular = norm(cross(h(1), bent)) < 1e-9 || norm(cross(h(1), u)) < 1e-9;
    out[3] = singular ? seed[3] : angle_about(h(1), bent, u);
    undo(1);
    undo(2);
  } else if (last == 2) {
    out[3] = angle_about(h(1), end, turn * end);
    undo(1);
  }
  out[2 + last] = angle_about(end, beside, seen);
}

void SlidingArm::solve_gantry(const PoseTarget& target, const double* seed, double side,
                              State& out) const noexcept {
  turn_wrist(target.rotation * transposed(arm_->tool_rotation), seed, side, out);
  for (std::size_t k = 0; k < 3; ++k) out[k] = 0;
  Rotation rotation;
  Vec3 position;
  arm_->forward({out.data(), arm_->count}, rotation, position);
  const Vec3 way = target.position - position;
  const Vec3 &a = arm_->axes[0].direction, &b = arm_->axes[1].direction, &c = arm_->axes[2].direction;
  const double volume = determinant(a, b, c);
  out[0] = determinant(way, b, c) / volume;
  out[1] = determinant(a, way, c) / volume;
  out[2] = determinant(a, b, way) / volume;
}

std::size_t SlidingArm::solve(const PoseTarget& target, const double* seed,
                              std::span<State, kMost> out) const noexcept {
  out[0] = out[1] = {};
  for (std::size_t k = 0; k < kMost; ++k) {
    const double side = k == 0 ? 1 : -1;
    if (kind_ == Kind::scara)
      solve_scara(target, seed, side, out[k]);
    else
      solve_gantry(target, seed, side, out[k]);
  }
  return kMost;
}

}  // namespace polyarm::kinematics
