#include "polyarm/kinematics/tree.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/tree_builder.hpp"

namespace polyarm::kinematics {
namespace {

Vec3 vec(const double* v) {
  return {v[0], v[1], v[2]};
}

/// The motion of a step relative to its parent, in the reference axes.
Pose motion_of(const TreeStep& step, std::span<const double> q) {
  const Vec3 h = vec(step.h), p = vec(step.p);
  switch (step.motion) {
    case Motion::held:
      return {p, {}};
    case Motion::slide:
      return {p + step.ratio * q[step.position] * h, {}};
    case Motion::ball: {
      const double* r = q.data() + step.position;
      const double* axes = step.ball_axes;
      const Vec3 u = r[0] * vec(axes) + r[1] * vec(axes + 3) + r[2] * vec(axes + 6);
      return {p, normalized(Quaternion{u.x, u.y, u.z, r[3]})};
    }
    default:
      return {p, from_axis_angle(h, step.ratio * q[step.position])};
  }
}

Quaternion exponential(const Vec3& rotation) {
  const double angle = norm(rotation);
  return angle > 0 ? from_axis_angle((1 / angle) * rotation, angle) : Quaternion{};
}

}  // namespace

Tree::Tree(const description::RobotModel& model, const TreeOptions& options) {
  TreeBuilder(model, options, *this).build();
}

std::vector<double> Tree::neutral() const {
  std::vector<double> out(positions(), 0.0);
  for (const TreeJoint& joint : joints_)
    if (joint.type == description::JointType::floating) out[joint.position + 6] = 1;
  return out;
}

void Tree::integrate(std::span<double> q, std::span<const double> v, double dt) const noexcept {
  for (const TreeJoint& joint : joints_) {
    const bool floats = joint.type == description::JointType::floating;
    double* at = q.data() + joint.position;
    const double* rate = v.data() + joint.velocity;
    const std::size_t straight = floats ? 3 : joint.velocities;
    for (std::size_t i = 0; i < straight; ++i) at[i] += dt * rate[i];
    if (!floats) continue;
    const Quaternion r = normalized(Quaternion{at[3], at[4], at[5], at[6]} * exponential(dt * vec(rate + 3)));
    at[3] = r.x, at[4] = r.y, at[5] = r.z, at[6] = r.w;
  }
}

Pose Tree::step_pose(std::span<const double> q, int step) const noexcept {
  Pose out;
  for (int k = step; k >= 0; k = model_.step[k].parent) out = motion_of(model_.step[k], q) * out;
  return T_world_reference_ * out;
}

Pose Tree::link_pose(std::span<const double> q, std::size_t link) const noexcept {
  return step_pose(q, links_[link].step) * links_[link].from_step;
}

void Tree::link_poses(std::span<const double> q, std::span<Pose> out) const noexcept {
  for (std::size_t i = 0; i < links_.size(); ++i) out[i] = link_pose(q, i);
}

Pose Tree::jacobian(std::span<const double> q, std::size_t link, const Vec3& point, std::span<double> J,
                    JacobianFrame frame) const noexcept {
  const std::size_t n = velocities();
  const Pose T_world_link = link_pose(q, link);
  const Vec3 at = frame == JacobianFrame::space ? Vec3{} : T_world_link * point;
  std::fill_n(J.begin(), 6 * n, 0.0);
  for (int k = links_[link].step; k >= 0; k = model_.step[k].parent) {
    const TreeStep& step = model_.step[k];
    const Pose here = step_pose(q, k);
    Vec3 axis = here.rotation * (step.ratio * vec(step.h)), linear = axis;
    if (step.motion == Motion::slide)
      axis = {};
    else
      linear = cross(axis, at - here.position);
    if (frame == JacobianFrame::body) {
      axis = inverse(T_world_link.rotation) * axis;
      linear = inverse(T_world_link.rotation) * linear;
    }
    const double column[] = {linear.x, linear.y, linear.z, axis.x, axis.y, axis.z};
    for (std::size_t r = 0; r < 6; ++r) J[r * n + step.velocity] += column[r];
  }
  return T_world_link;
}

double Tree::mass() const noexcept {
  double out = 0;
  for (std::size_t k = 0; k < model_.steps; ++k) out += model_.step[k].mass;
  return out;
}

std::vector<std::string> Tree::massless_joints() const {
  std::vector<double> behind(model_.steps, 0.0), moved(velocities(), 0.0);
  for (std::size_t k = model_.steps; k-- > 0;) {
    const TreeStep& step = model_.step[k];
    behind[k] += step.mass;
    if (step.parent >= 0) behind[static_cast<std::size_t>(step.parent)] += behind[k];
    moved[step.velocity] += behind[k];
  }
  std::vector<std::string> out;
  for (const TreeJoint& joint : joints_)
    if (!(moved[joint.velocity] > 0)) out.push_back(joint.name);
  return out;
}

double Tree::potential_energy(std::span<const double> q) const noexcept {
  double out = 0;
  for (std::size_t k = 0; k < model_.steps; ++k) {
    const TreeStep& step = model_.step[k];
    if (step.mass == 0) continue;
    const Pose at = step_pose(q, static_cast<int>(k));
    out -= dot(gravity_, step.mass * at.position + at.rotation * vec(step.moment));
  }
  return out;
}

}  // namespace polyarm::kinematics
