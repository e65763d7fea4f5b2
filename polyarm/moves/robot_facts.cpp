#include "polyarm/moves/robot_facts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/moves/rounded_poses.hpp"

namespace polyarm::moves {

std::shared_ptr<const RobotFacts> with_chain(const RobotFacts& robot, kinematics::Chain chain) {
  auto solver = std::make_unique<const ik::InverseKinematics>(chain);
  return std::make_shared<const RobotFacts>(RobotFacts{robot.name, robot.model, std::move(chain),
                                                       robot.limits, robot.tcp, robot.home, std::move(solver),
                                                       robot.workspace, robot.torques});
}

std::vector<double> joints_for(const RobotFacts& robot, const Pose& tcp, std::span<const double> current,
                               const std::string& what) {
  std::optional<ik::InverseKinematics> own;
  const ik::InverseKinematics& arm = robot.solver ? *robot.solver : own.emplace(robot.chain);
  ik::IkSolution found;
  const auto taken = [&](const ik::IkSolution& solution) {
    return std::vector<double>(solution.q.begin(),
                               solution.q.begin() + static_cast<std::ptrdiff_t>(robot.chain.joints()));
  };
  const std::optional<Pose> straight = straightened(robot, tcp);
  if (straight && arm.solve_move(*straight, current, robot.home, found) == ik::IkOutcome::solved &&
      found.exact)
    return taken(found);
  if (arm.solve_move(tcp, current, robot.home, found) == ik::IkOutcome::solved) return taken(found);
  const ik::IkExplanation why = arm.explain(tcp, current);
  const std::optional<Pose> near = nearest_reached(robot, arm, tcp, why);
  if (near && arm.solve_move(*near, current, robot.home, found) == ik::IkOutcome::solved) return taken(found);
  throw Error(
      why.outcome == ik::IkOutcome::limits ? "limit" : "unreachable",
      fmt::format("{} cannot be reached by {} ({}): {}", what, robot.name, robot.model->name, why.reason),
      "move the point, the robot's base, or choose a robot that reaches it");
}

void check_joints(const RobotFacts& robot, std::span<const double> joints, const std::string& what) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const double lower = robot.chain.lower()[j], upper = robot.chain.upper()[j];
    if (joints[j] >= lower - 1e-9 && joints[j] <= upper + 1e-9) continue;
    throw Error("limit",
                fmt::format("{} puts {} at {}, its limits are {:.4f} to {:.4f}", what, robot.model->joint_names()[j],
                            std::abs(joints[j]) < 1e6 ? fmt::format("{:.4f}", joints[j]) : fmt::format("{:g}", joints[j]),
                            lower, upper),
                what.starts_with("speedj")   ? "give a lower speed or a shorter duration"
                : std::abs(joints[j]) > 7 ? "this looks like degrees; joint values are radians"
                                        : "choose a value inside");
  }
}

}  // namespace polyarm::moves
