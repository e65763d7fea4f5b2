#include "drivers/mujoco/servo.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::drivers {

namespace {
constexpr double kBandwidth = 100;       // rad/s
constexpr double kUnstatedEffort = 300;  // Nm or N, if the description states no limit
/// Share of the acceleration that the effort limit allows, with which a joint brakes onto its set point.
constexpr double kBraking = 0.5;

/// The acceleration, within its effort, of a joint `error` away from its set point: it approaches as fast as it can
/// brake with `braking`. Near the set point this is the critically damped correction.
double catch_up(double error, double velocity, double braking) noexcept {
  constexpr double kGain = kBandwidth / 2;
  const double far = std::abs(error), linear = braking / (kGain * kGain);
  const double approach = far <= linear ? kGain * far : std::sqrt(2 * braking * (far - linear / 2));
  return 2 * kBandwidth * (std::copysign(approach, error) - velocity);
}
}  // namespace

Servo::Servo(const hardware::RobotInstance& robot) {
  for (const int index : robot.model->actuated) {
    Joint joint;
    const auto& effort = robot.model->joints[static_cast<std::size_t>(index)].limits.effort;
    joint.limit = effort && *effort > 0 ? *effort : kUnstatedEffort;
    joints_.push_back(joint);
  }
}

void Servo::start_at(std::span<const double> positions) noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    joints_[j].reference = joints_[j].target = positions[j];
    joints_[j].velocity = joints_[j].acceleration = 0;
  }
}

void Servo::start(std::size_t j, JointMode mode, double position, double velocity) noexcept {
  Joint& joint = joints_[j];
  const bool same = joint.led && joint.mode == mode;
  joint.mode = mode;
  joint.led = true;
  if (same) return;
  joint.commanded = joint.behind = false;
  joint.reference = joint.target = position;
  joint.velocity = velocity;
  joint.acceleration = 0;
  joint.effort = joint.torque;
}

void Servo::stop(std::size_t j, JointMode mode, double position) noexcept {
  Joint& joint = joints_[j];
  if (!joint.led || joint.mode != mode) return;
  joint.led = joint.commanded = false;
  if (mode == JointMode::position) return;  // its set point stays
  joint.mode = JointMode::position;
  joint.behind = false;
  joint.reference = joint.target = position;
  joint.velocity = joint.acceleration = 0;
}

void Servo::command(std::span<const double> position, std::span<const double> velocity,
                    std::span<const double> effort, double period) noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    if (joint.led && joint.mode == JointMode::effort) {
      if (std::isfinite(effort[j])) joint.effort = effort[j];
      continue;
    }
    double wanted = joint.velocity;
    if (joint.mode == JointMode::position) {
      if (joint.led && std::isfinite(position[j])) {
        joint.target = position[j];
        joint.commanded = true;
      }
      wanted = (joint.target - joint.reference) / period;
    } else if (std::isfinite(velocity[j])) {
      wanted = velocity[j];
    }
    joint.acceleration = (wanted - joint.velocity) / period;
  }
}

/// What its effort can do beside carrying the arm, when the other joints do not accelerate.
double Servo::strongest_acceleration(const Joint& joint, const ModelView& view, int dof) noexcept {
  constexpr double kLeast = 0.05;  // of the effort, for a joint whose load takes it all
  const mjData* d = view.d();
  const double left = joint.limit - std::abs(d->qfrc_bias[dof]);
  return std::max(left, kLeast * joint.limit) / d->qM[view.m()->dof_Madr[dof]];
}

void Servo::accelerations(const ModelView& view, std::size_t robot, mjtNum* acceleration,
                          double timestep) noexcept {
  const ModelView::Robot& r = view.robots[robot];
  const mjData* d = view.d();
  tracking_error_ = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    const double q = d->qpos[r.qpos[j]], v = d->qvel[r.dof[j]];
    double& a = acceleration[r.dof[j]];
    a = 0;
    if (joint.mode == JointMode::effort) continue;
    a = joint.acceleration + 2 * kBandwidth * (joint.velocity - v);
    if (joint.mode == JointMode::position) {
      a += kBandwidth * kBandwidth * (joint.reference - q);
      // A set point that jumps would be overshot: its effort stops the joint later than the correction expects.
      const double strongest = strongest_acceleration(joint, view, r.dof[j]);
      if (std::abs(joint.acceleration) > strongest) joint.behind = true;
      if (joint.behind && std::abs(a) <= kBraking * strongest) joint.behind = false;
      if (joint.behind)  // more than it can do would also be charged to the other joints
        a = std::clamp(catch_up(joint.reference - q, v, kBraking * strongest), -strongest, strongest);
      if (joint.commanded) tracking_error_ = std::max(tracking_error_, std::abs(joint.reference - q));
    }
    joint.velocity += joint.acceleration * timestep;
    joint.reference += joint.velocity * timestep;  // in the integration order of the simulator
  }
  for (const auto& f : r.followers) acceleration[f.dof] = f.multiplier * acceleration[r.dof[f.source]];
}

void Servo::torques(const ModelView& view, std::size_t robot, const mjtNum* inertial_force) noexcept {
  const ModelView::Robot& r = view.robots[robot];
  mjData* d = view.d();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    const int dof = r.dof[j];
    const double wanted = joint.mode == JointMode::effort
                              ? joint.effort
                              : inertial_force[dof] + d->qfrc_bias[dof] - d->qfrc_passive[dof];
    joint.torque = std::clamp(wanted, -joint.limit, joint.limit);
    const bool braked = joint.mode == JointMode::position && !joint.commanded;
    if (braked && joint.torque != wanted) joint.reference = joint.target = d->qpos[r.qpos[j]];  // the brake slips
    d->qfrc_applied[dof] = joint.torque;
  }
  for (const auto& f : r.followers)  // followers carry their own weight, which relieves the coupling
    d->qfrc_applied[f.dof] = inertial_force[f.dof] + d->qfrc_bias[f.dof] - d->qfrc_passive[f.dof];
}

}  // namespace polyarm::drivers
