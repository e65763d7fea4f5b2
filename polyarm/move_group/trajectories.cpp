#include "polyarm/move_group/trajectories.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "polyarm/move_group/plans.hpp"
#include "polyarm/planning/planner.hpp"

namespace polyarm::move_group {

namespace {

constexpr double kStep = 0.02;            // s between points
constexpr std::size_t kMostSteps = 1000;  // of one trajectory: longer ones have longer steps
/// Between states on a line that is near something all along, rad or m, and their greatest number.
constexpr double kCloseStep = 0.002, kMostClose = 10'000;

messages::builtin_interfaces::msg::Duration duration_of(double seconds) {
  const double whole = std::floor(seconds);
  return {static_cast<std::int32_t>(whole),
          static_cast<std::uint32_t>(std::min((seconds - whole) * 1e9, 999'999'999.0))};
}

/// The first contact of the states along a line; none if there is none.
std::optional<collision::Contact> contact_along(collision::Probe& probe, const std::vector<double>& from,
                                                const std::vector<double>& to) {
  double most = 0;
  for (std::size_t j = 0; j < from.size(); ++j) most = std::max(most, std::abs(to[j] - from[j]));
  const int steps = static_cast<int>(std::min(std::ceil(most / kCloseStep), kMostClose)) + 1;
  std::vector<double> q(from.size());
  for (int k = 0; k <= steps; ++k) {
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = from[j] + (to[j] - from[j]) * k / steps;
    if (!probe.touches_exactly(q)) continue;
    if (const collision::Contact contact = probe.nearest(q); contact.distance <= 0) return contact;
  }
  return std::nullopt;
}

}  // namespace

msg::RobotTrajectory to_message(const Arm& arm, const Group& group, const moves::MovePlan& plan,
                                std::span<const double> start) {
  msg::RobotTrajectory out;
  auto& trajectory = out.joint_trajectory;
  trajectory.header.frame_id = arm.planning_frame();
  for (const std::size_t variable : group.variables) trajectory.joint_names.push_back(arm.joints()[variable]);
  const std::size_t n = arm.joints().size();
  std::vector<double> q(start.begin(), start.end()), v(n), a(n);
  const auto add = [&](double time) {
    auto& point = trajectory.points.emplace_back();
    for (const std::size_t variable : group.variables) {
      point.positions.push_back(q[variable]);
      point.velocities.push_back(v[variable]);
      point.accelerations.push_back(a[variable]);
    }
    point.time_from_start = duration_of(time);
  };
  if (plan.motions.empty()) add(0);
  double begin = 0;
  for (const moves::PlannedMotion& motion : plan.motions) {
    const double duration = motion.path.duration();
    const auto steps =
        std::clamp(static_cast<std::size_t>(std::ceil(duration / kStep)), std::size_t{1}, kMostSteps);
    std::size_t hint = 0;
    for (std::size_t i = trajectory.points.empty() ? 0 : 1; i <= steps; ++i) {
      const double t = duration * static_cast<double>(i) / static_cast<double>(steps);
      motion.path.sample(t, q, v, a, {}, hint);
      add(begin + t);
    }
    begin += duration;
  }
  for (double& value : trajectory.points.back().velocities) value = 0;  // it ends at rest
  for (double& value : trajectory.points.back().accelerations) value = 0;
  return out;
}

void along(const moves::MovePlan& plan, double step,
           const std::function<bool(std::span<const double>)>& look) {
  for (const moves::PlannedMotion& motion : plan.motions) {
    const double duration = motion.path.duration();
    const auto steps = static_cast<std::size_t>(std::ceil(duration / step)) + 1;
    std::vector<double> q(motion.path.joints());
    std::size_t hint = 0;
    for (std::size_t i = 0; i <= steps; ++i) {
      motion.path.sample(duration * static_cast<double>(i) / static_cast<double>(steps), q, {}, {}, {}, hint);
      if (!look(q)) return;
    }
  }
}

void check_free(surroundings::Surroundings& around, const std::vector<std::vector<double>>& states, int code,
                const std::string& what) {
  collision::EdgeOptions options;
  options.exact = true;
  for (std::size_t i = 1; i < states.size(); ++i) {
    const collision::EdgeAnswer answer = around.probe().edge(states[i - 1], states[i], options);
    if (answer.verdict == collision::EdgeVerdict::free) continue;
    std::vector<double> q = states[i - 1];
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += answer.at * (states[i][j] - q[j]);
    collision::Contact contact = around.probe().nearest(q);
    if (answer.verdict == collision::EdgeVerdict::close && contact.distance > 0) {
      // Near, and not in contact there. The proof ended at that place: the rest is looked at state by state.
      const auto touching = contact_along(around.probe(), states[i - 1], states[i]);
      if (!touching) continue;
      contact = *touching;
    }
    throw Refusal(code, what + ": " + planning::text_of(contact));
  }
}

std::string body_name(const std::string& body) {
  for (const std::string kind : {"fixture ", "part "})
    if (body.starts_with(kind)) return body.substr(kind.size());
  return body;
}

std::uint32_t body_type(const std::string& body) {
  if (body.starts_with("part ") || body == "tool" || body == "fingers")
    return msg::ContactInformation::ROBOT_ATTACHED;
  return body.starts_with("fixture ") || body == "floor" || body.find('/') != std::string::npos
             ? msg::ContactInformation::WORLD_OBJECT
             : msg::ContactInformation::ROBOT_LINK;
}

}  // namespace polyarm::move_group
