#pragma once
/// A joint trajectory controller on joints that are where they were told to be, or that stay where they are.
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

inline trajectory::TrajectoryPoint point(double time, std::vector<double> positions,
                                         std::vector<double> velocities = {},
                                         std::vector<double> accelerations = {}) {
  trajectory::TrajectoryPoint out;
  out.time_from_start = time;
  out.positions = std::move(positions);
  out.velocities = std::move(velocities);
  out.accelerations = std::move(accelerations);
  return out;
}

/// Joints j1 to jN of a robot `arm`; ten milliseconds a cycle.
struct TrajectoryRig {
  static constexpr Nanoseconds kPeriod = 10'000'000;
  JointTrajectoryController jtc;
  ControllerContext context;
  std::vector<double> states, commands, positions, velocities;
  std::size_t n;
  Cycle cycle{0, kPeriod, 0};
  Verdict verdict;
  bool follows = true;  ///< states follow commands; else they stay
  std::vector<GoalEvent> events;

  explicit TrajectoryRig(std::vector<double> start = {1.1, 2.1, 3.1}) : positions(start), n(start.size()) {
    velocities.assign(n, 0.0);
    context.name = "jtc";
    context.robot = "arm";
    context.period = kPeriod;
    std::vector<std::string> joints;
    for (std::size_t j = 0; j < n; ++j) {
      const std::string name = "j" + std::to_string(j + 1);
      joints.push_back(name);
      context.joints.push_back({"arm/" + name, false, -100, 100, 1e6, 1e9, kUnlimited});
      for (const char* quantity : {"position", "velocity", "acceleration", "effort"}) {
        context.state_names.push_back("arm/" + name + "/" + quantity);
        context.command_names.push_back("arm/" + name + "/" + quantity);
      }
    }
    set("joints", joints);
  }
  void set(const std::string& key, std::vector<std::string> values) {
    Parameters::Entry entry;
    entry.list = values.size() != 1;
    entry.values = std::move(values);
    entry.where = {"controllers.yaml", 7};
    context.parameters.entries[key] = std::move(entry);
  }
  void configure() {
    ASSERT_EQ(jtc.on_configure(context), CallbackReturn::success);
    context.parameters.problems().throw_if_errors();
    states.assign(jtc.state_interfaces().size(), 0.0);
    commands.assign(jtc.command_interfaces().size(), std::numeric_limits<double>::quiet_NaN());
    Bindings bindings{states, commands, {}, {}, {}, states, {}};
    for (std::size_t i = 0; i < states.size(); ++i) bindings.state.push_back(i);
    for (std::size_t i = 0; i < commands.size(); ++i) bindings.command.push_back(i);
    jtc.bind(bindings);
  }
  void activate() {
    measure();
    ASSERT_EQ(jtc.on_activate(cycle), CallbackReturn::success);
  }
  void start() {
    configure();
    activate();
  }
  void measure() {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const std::string& name = jtc.state_interfaces()[i];
      const auto j = static_cast<std::size_t>(name[5] - '1');
      states[i] = name.ends_with("position") ? positions[j] : name.ends_with("velocity") ? velocities[j] : 0;
    }
  }
  double commanded(std::size_t j, const std::string& quantity = "position") const {
    const auto& names = jtc.command_interfaces();
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == "arm/j" + std::to_string(j + 1) + "/" + quantity) return commands[i];
    return std::numeric_limits<double>::quiet_NaN();
  }
  void step() {
    measure();
    EXPECT_EQ(jtc.update(cycle, verdict), ReturnType::ok);
    cycle.time += kPeriod;
    ++cycle.index;
    while (auto event = jtc.next_goal_event()) events.push_back(*event);
    if (!follows) return;
    for (std::size_t j = 0; j < n; ++j) {
      if (const double p = commanded(j); std::isfinite(p)) positions[j] = p;
      if (const double v = commanded(j, "velocity"); std::isfinite(v)) velocities[j] = v;
    }
  }
  void run(double seconds) {
    for (int k = 0; k < std::lround(seconds * 100); ++k) step();
  }
  TrajectoryMessage message(std::vector<trajectory::TrajectoryPoint> points,
                            std::vector<std::string> joints = {}) {
    TrajectoryMessage out;
    for (std::size_t j = 0; joints.empty() && j < n; ++j) out.joints.push_back("j" + std::to_string(j + 1));
    if (!joints.empty()) out.joints = std::move(joints);
    out.points = std::move(points);
    return out;
  }
  std::uint64_t send(std::vector<trajectory::TrajectoryPoint> points, std::vector<std::string> joints = {}) {
    return jtc.receive("joint_trajectory", message(std::move(points), std::move(joints)), false);
  }
  std::uint64_t send_goal(TrajectoryMessage message) {
    return jtc.receive("follow_joint_trajectory", message, true);
  }
  const GoalEvent* last() const { return events.empty() ? nullptr : &events.back(); }
};

}  // namespace polyarm::controllers
