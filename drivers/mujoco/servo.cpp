#include "drivers/mujoco/servo.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::drivers {

namespace {
constexpr double kBandwidth = 100;       // rad/s
constexpr double kUnstatedEffort = 300;  // Nm or N, if the description states no limit
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
  joint.follows = false;
  joint.reference = joint.target = position;
  joint.velocity = velocity;
  joint.acceleration = 0;
  joint.effort = joint.torque;
}

void Servo::stop(std::size_t j, JointMode mode, double position) noexcept {
  Joint& joint = joints_[j];
  if (!joint.led || joint.mode != mode) return;
  joint.led = joint.follows = false;
  if (mode == JointMode::position) return;  // its set point stays
  joint.mode = JointMode::position;
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
        joint.follows = true;
      }
      wanted = (joint.target - joint.reference) / period;
    } else if (std::isfinite(velocity[j])) {
      wanted = velocity[j];
    }
    joint.acceleration = (wanted - joint.velocity) / period;
  }
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
      if (joint.follows) tracking_error_ = std::max(tracking_error_, std::abs(joint.reference - q));
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
    d->qfrc_applied[dof] = joint.torque;
  }
  for (const auto& f : r.followers)  // followers carry their own weight, which relieves the coupling
    d->qfrc_applied[f.dof] = inertial_force[f.dof] + d->qfrc_bias[f.dof] - d->qfrc_passive[f.dof];
}

}  // namespace polyarm::drivers
