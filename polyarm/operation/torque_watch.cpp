#include "polyarm/operation/torque_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::cell {

namespace {
constexpr double kSmoothing =
    0.006;                  // s: a velocity that is measured in two ticks gives a rough acceleration
constexpr int kFirst = 25;  // ticks until the filter has settled

double limit_of(const RobotEntry& entry, const std::string& joint) {
  double out = 0;
  for (const CollisionTorqueEntry& each : entry.collision_torques)
    if (each.joint.empty() || each.joint == joint) out = each.limit;
  return out;
}
}  // namespace

TorqueWatch::TorqueWatch(const CellSetup& setup, const Machine& machine, std::vector<std::string>& notes)
    : setup_(setup), machine_(machine) {
  for (std::size_t r = 0; r < setup.robots.size(); ++r) {
    const CellRobot& robot = *setup.robots[r];
    if (robot.entry.collision_torques.empty()) continue;
    std::vector<Joint> joints;
    bool measured = true;
    for (const int index : robot.model.actuated) {
      const description::Joint& joint = robot.model.joints[static_cast<std::size_t>(index)];
      Joint out;
      out.name = joint.name;
      out.limit = limit_of(robot.entry, joint.name);
      out.slides = joint.type == description::JointType::prismatic;
      const auto state = [&](const char* quantity) {
        const auto found = machine.table().find_state(robot.entry.name + "/" + joint.name + "/" + quantity);
        measured = measured && found;
        return found.value_or(0);
      };
      out.position = state("position"), out.velocity = state("velocity"), out.effort = state("effort");
      joints.push_back(std::move(out));
    }
    try {
      kinematics::Dynamics dynamics = moves::loaded_dynamics(robot.model, robot.entry.base, load_of(robot));
      const std::size_t n = joints.size();
      measured = measured && dynamics.tree().positions() == n && dynamics.tree().velocities() == n;
      const std::vector<double> zeros(n, 0.0);
      if (measured) arms_.push_back({r, std::move(dynamics), std::move(joints), zeros, zeros, zeros, zeros});
    } catch (const Error&) {  // a model without masses
      measured = false;
    }
    if (!measured)
      notes.push_back(
          "'" + robot.entry.name +
          "': collision_torque has no effect: its hardware measures no torques, or its masses are unknown");
  }
}

/// The torques that the motors exert beyond those that the model needs for the measured motion.
void TorqueWatch::measure(Arm& arm, double dt) {
  const std::vector<double>& states = machine_.snapshot().states;
  for (std::size_t j = 0; j < arm.joints.size(); ++j) {
    Joint& joint = arm.joints[j];
    arm.q[j] = states[joint.position];
    arm.v[j] = states[joint.velocity];
    arm.a[j] = (arm.v[j] - std::exchange(joint.before, arm.v[j])) / dt;
  }
  arm.dynamics.inverse(arm.q, arm.v, arm.a, arm.tau);
  const double share = dt / (dt + kSmoothing);
  for (std::size_t j = 0; j < arm.joints.size(); ++j) {
    Joint& joint = arm.joints[j];
    const double outside = states[joint.effort] - arm.tau[j];
    if (std::isfinite(outside)) joint.outside += share * (outside - joint.outside);
  }
}

void TorqueWatch::forget() {
  for (Arm& arm : arms_) arm.over = false;
}

std::optional<TorqueWatch::Found> TorqueWatch::tick() {
  const Nanoseconds now = machine_.snapshot().cycle.time;
  const double dt = seconds(now - std::exchange(time_, now));
  std::optional<Found> out;
  for (Arm& arm : arms_) {
    if (!(dt > 0)) continue;
    measure(arm, dt);
    if (++arm.ticks < kFirst) continue;
    double most = 0;
    const Joint* worst = nullptr;
    for (const Joint& joint : arm.joints)
      if (joint.limit > 0 && std::abs(joint.outside) / joint.limit > most)
        most = std::abs(joint.outside) / joint.limit, worst = &joint;
    if (most < 0.5) arm.over = false;
    if (most <= 1 || std::exchange(arm.over, true)) continue;
    out = Found{arm.robot, worst->name, worst->outside, worst->limit, worst->slides};
  }
  return out;
}

}  // namespace polyarm::cell
