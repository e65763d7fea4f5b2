#pragma once
/// What drivers of robots with six axes share: which joints they drive, the limits that the description has,
/// and the check of each command. Any thread.
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/wire/shaper.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::wire {

/// The joints that a component with one robot of six axes drives, from base to tool: those of its
/// <ros2_control> block, else the first six of the model. Commands must be among `takes`; what is wrong goes
/// to `problems`. `whose`: "robots of ABB".
std::vector<std::string> driven_joints(const hardware::ComponentContext& context,
                                       std::span<const char* const> takes, const std::string& whose,
                                       Problems& problems);
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
Six start_position(const hardware::RobotInstance& robot, Six otherwise, double scale);

/// Finds commands that are too far from the last one, or at the beginning from the measured position. rad.
/// Control thread.
class StepCheck {
 public:
  static constexpr double kFirstStep = 0.01;
  explicit StepCheck(double most = 0.1) noexcept : most_(most) {}
  void begin() noexcept { first_ = true; }
  /// The first joint that jumps; nothing if none does, and then `joints` count as sent.
  std::optional<int> jumps(const Six& joints, const Six& measured) noexcept {
    for (std::size_t j = 0; j < 6; ++j)
      if (std::abs(joints[j] - (first_ ? measured[j] : sent_[j])) > (first_ ? kFirstStep : most_))
        return static_cast<int>(j);
    sent_ = joints;
    first_ = false;
    return std::nullopt;
  }

 private:
  double most_;
  bool first_ = true;
  Six sent_{};
};

}  // namespace polyarm::wire
