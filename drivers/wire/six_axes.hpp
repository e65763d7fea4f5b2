#pragma once
/// What drivers of robot arms share, most of which have six axes: which joints they drive, the limits that
/// the description has, and the check of each command. Any thread.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/wire/shaper.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::wire {

inline constexpr double kRadians = std::numbers::pi / 180;  ///< rad in a degree
inline constexpr double kDegrees = 180 / std::numbers::pi;  ///< degrees in a rad
inline Six scaled(const Six& six, double by) noexcept {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = by * six[i];
  return out;
}

/// The joints that a component with one robot of six axes drives, from base to tool: those of its
/// <ros2_control> block, else the first six of the model. Commands must be among `takes`; what is wrong goes
/// to `problems`. `whose`: "robots of ABB"; a maker with other arms says how many axes they have.
std::vector<std::string> driven_joints(const hardware::ComponentContext& context,
                                       std::span<const char* const> takes, const std::string& whose,
                                       Problems& problems, std::size_t least = 6, std::size_t most = 6);
/// The revolute joints of a model in a chain, `least` to `most` of them. Throws Error("bad-model");
/// `example`: "abb/irb_120".
std::vector<const description::Joint*> revolute_joints(const description::RobotModel& model,
                                                       std::size_t least, std::size_t most,
                                                       const std::string& example);
/// The link of one of the usual names of a flange, else `last`.
int flange_link(const description::RobotModel& model, int last);
/// The six revolute joints of a model in a chain. Throws Error("bad-model"); `example`: "abb/irb_120".
std::array<const description::Joint*, 6> six_revolute_joints(const description::RobotModel& model,
                                                             const std::string& example);
/// What a simulated controller takes from a model of six revolute joints in a chain.
struct AxisFacts {
  std::string model;                 ///< without its maker
  Six lower{}, upper{}, velocity{};  ///< times `scale`; joints without limits have 36000 and 2 rad/s
  int flange = 0;                    ///< the link of one of its usual names, else that of the last joint
};
/// Throws as six_revolute_joints() does.
AxisFacts axis_facts(const description::RobotModel& model, const std::string& example, double scale);
/// The positions where a cell begins, times `scale`; `otherwise` for those that it does not have.
template <std::size_t N>
std::array<double, N> start_position(const hardware::RobotInstance& robot, std::array<double, N> otherwise,
                                     double scale) {
  for (std::size_t i = 0; i < std::min(N, robot.initial_positions.size()); ++i)
    otherwise[i] = robot.initial_positions[i] * scale;
  return otherwise;
}

/// Limits of acceleration and jerk for streamed commands: shares of those of the description.
struct LimitShares {
  double acceleration = 2, jerk = 8;
  double acceleration_else = 400, jerk_else = 20000;  ///< of a joint without such a limit
};
/// Limits in units of which one rad has `scale`; `max_speed` in them.
template <std::size_t N>
AxisLimitsOf<N> stream_limits(const hardware::RobotInstance& robot, const std::vector<std::string>& joints,
                              double max_speed, const LimitShares& shares, double scale) {
  AxisLimitsOf<N> out;
  auto& [velocity, acceleration, jerk] = out.of;
  velocity.fill(max_speed);
  acceleration.fill(shares.acceleration_else);
  jerk.fill(shares.jerk_else);
  if (!robot.model) return out;
  for (std::size_t i = 0; i < joints.size(); ++i)
    for (const description::Joint& joint : robot.model->joints)
      if (joint.name == joints[i]) {
        if (const auto a = joint.limits.acceleration) acceleration[i] = shares.acceleration * *a * scale;
        if (const auto j = joint.limits.jerk) jerk[i] = shares.jerk * *j * scale;
      }
  return out;
}

/// Finds commands that are too far from the last one, or at the beginning from the measured position. rad.
/// Control thread.
template <std::size_t N>
class StepCheckOf {
 public:
  using Axes = std::array<double, N>;
  static constexpr double kFirstStep = 0.01;
  explicit StepCheckOf(double most = 0.1) noexcept : most_(most) {}
  void begin() noexcept { first_ = true; }
  /// The first joint that jumps; nothing if none does, and then `joints` count as sent.
  std::optional<int> jumps(const Axes& joints, const Axes& measured) noexcept {
    for (std::size_t j = 0; j < N; ++j)
      if (std::abs(joints[j] - (first_ ? measured[j] : sent_[j])) > (first_ ? kFirstStep : most_))
        return static_cast<int>(j);
    sent_ = joints;
    first_ = false;
    return std::nullopt;
  }

 private:
  double most_;
  bool first_ = true;
  Axes sent_{};
};
using StepCheck = StepCheckOf<6>;

}  // namespace polyarm::wire
