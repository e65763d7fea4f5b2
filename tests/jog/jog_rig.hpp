#pragma once
/// Arms of the catalogue that are moved by hand, and the laws that every cycle has to keep.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/jog/jog_generator.hpp"

namespace polyarm::test {

inline std::vector<jog::AxisLimits> axis_limits(const description::RobotModel& model) {
  std::vector<jog::AxisLimits> out;
  for (const int index : model.actuated) {
    const auto& limits = model.joints[static_cast<std::size_t>(index)].limits;
    jog::AxisLimits axis;
    axis.lower = limits.lower.value_or(-INFINITY);
    axis.upper = limits.upper.value_or(INFINITY);
    axis.velocity = limits.velocity.value_or(1.0);
    axis.acceleration = axis.velocity / 0.25;
    axis.jerk = axis.acceleration / 0.1;
    out.push_back(axis);
  }
  return out;
}

/// An arm with what it may do; the laws are checked in every cycle.
class JogRig {
 public:
  explicit JogRig(const std::string& robot, moves::Workspace workspace = {}, double cycle = 0.001)
      : JogRig(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(robot), std::move(workspace),
               cycle) {}
  explicit JogRig(description::RobotModel robot, moves::Workspace workspace = {}, double cycle = 0.001)
      : dt(cycle),
        model(std::move(robot)),
        chain(model, model.tool_link()),
        generator(chain, axis_limits(model), std::move(workspace), cycle) {}

  void start(const std::vector<double>& q) {
    generator.start(q);
    history_.assign(4, q);
    tcp_ = chain.forward(q).position;
  }
  /// A joint state in the middle of everything.
  std::vector<double> middle() const {
    std::vector<double> q;
    for (std::size_t j = 0; j < chain.joints(); ++j) {
      const jog::AxisLimits& a = generator.axes()[j];
      const double low = std::max(a.lower, -2.5), high = std::min(a.upper, 2.5);
      q.push_back(low + (0.35 + 0.05 * static_cast<double>(j)) * (high - low));
    }
    return q;
  }
  std::vector<double> joints() const {
    std::vector<double> q;
    for (std::size_t j = 0; j < chain.joints(); ++j) q.push_back(generator.axis(j).position);
    return q;
  }
  Pose tcp() const { return chain.forward(joints()); }

  /// One cycle; false when a law is broken, with the reason in `broken`.
  bool step(const jog::JogSetpoint& wish) {
    const bool began = generator.standing();
    generator.step(wish, limits);
    history_.erase(history_.begin());
    history_.push_back(joints());
    ++cycles;
    for (std::size_t j = 0; j < chain.joints(); ++j) judge_joint(j);
    const Vec3 before = std::exchange(tcp_, tcp().position);
    fastest = std::max(fastest, norm(tcp_ - before) / dt);
    for (std::size_t i = 0; i < generator.workspace().boundaries(); ++i)
      if (generator.workspace().counts(i, limits.reduced))
        nearest = std::min(nearest, generator.workspace().distance(i, tcp(), joints()).distance);
    (void)began;
    return broken.empty();
  }
  /// `seconds` of one wish, or until it is over.
  bool run(const jog::JogSetpoint& wish, double seconds) {
    for (double t = 0; t < seconds; t += dt)
      if (!step(wish)) return false;
    return true;
  }

  const double dt;
  description::RobotModel model;
  kinematics::Chain chain;
  jog::JogGenerator generator;
  jog::JogLimits limits;
  std::string broken;
  double fastest = 0, nearest = 1e9;
  std::size_t cycles = 0;

 private:
  void judge_joint(std::size_t j) {
    const jog::AxisLimits& a = generator.axes()[j];
    const jog::AxisState& s = generator.axis(j);
    const auto q = [&](std::size_t i) { return history_[i][j]; };
    const auto say = [&](const char* what, double value, double limit) {
      if (broken.empty())
        broken = chain.names()[j] + " " + what + " " + std::to_string(value) + ", limit " +
                 std::to_string(limit) + ", cycle " + std::to_string(cycles);
    };
    constexpr double kSlack = 1 + 1e-6;
    if (!std::isfinite(s.position)) say("position", s.position, a.upper);
    if (s.position > a.upper + 1e-9 || s.position < a.lower - 1e-9) say("position", s.position, a.upper);
    if (std::abs(s.velocity) > a.velocity * kSlack) say("velocity", s.velocity, a.velocity);
    if (std::abs(s.acceleration) > a.acceleration * kSlack)
      say("acceleration", s.acceleration, a.acceleration);
    // What is commanded, differentiated: velocity, acceleration, jerk of the positions themselves.
    const double v = (q(3) - q(2)) / dt, acc = (q(3) - 2 * q(2) + q(1)) / (dt * dt);
    const double jerk = (q(3) - 3 * q(2) + 3 * q(1) - q(0)) / (dt * dt * dt);
    const double rounding = 8e-16 * std::max(1.0, std::abs(q(3))) * 8 / (dt * dt * dt);
    if (std::abs(v) > a.velocity * kSlack + 1e-9) say("commanded velocity", v, a.velocity);
    if (std::abs(acc) > a.acceleration * kSlack + rounding * dt)
      say("commanded acceleration", acc, a.acceleration);
    if (std::abs(jerk) > a.jerk * kSlack + rounding) say("commanded jerk", jerk, a.jerk);
  }

  std::vector<std::vector<double>> history_;
  Vec3 tcp_;
};

inline jog::JogSetpoint tcp_setpoint(const jog::Twist& twist, bool tool = false) {
  jog::JogSetpoint wish;
  wish.kind = jog::JogSetpoint::Kind::tcp_velocity;
  wish.twist = twist;
  wish.tool_frame = tool;
  return wish;
}
inline jog::JogSetpoint joint_setpoint(std::size_t joint, double velocity) {
  jog::JogSetpoint wish;
  wish.kind = jog::JogSetpoint::Kind::joint_velocity;
  wish.joints[joint] = velocity;
  return wish;
}

}  // namespace polyarm::test
