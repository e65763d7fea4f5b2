#include "polyarm/moves/rounded_poses.hpp"

#include <cstddef>
#include <vector>

namespace polyarm::moves {

namespace {

std::span<const double> joints_of(const RobotFacts& robot, const ik::IkSolution& found) {
  return {found.q.data(), robot.chain.joints()};
}

bool has_fewer_axes(const kinematics::Chain& chain) {
  std::size_t moving = 0;
  for (std::size_t j = 0; j < chain.joints(); ++j) moving += chain.moves_tcp(j) ? 1 : 0;
  return moving < 6;
}

}  // namespace

std::optional<Pose> straightened(const RobotFacts& robot, const Pose& tcp) {
  if (!has_fewer_axes(robot.chain)) return std::nullopt;
  const std::vector<kinematics::Chain::Axis> axes = robot.chain.axes();
  if (axes.empty()) return std::nullopt;
  const Vec3 z = tcp.rotation * Vec3{0, 0, 1};
  const Vec3 along = dot(z, axes.front().direction) < 0 ? -axes.front().direction : axes.front().direction;
  if (!(norm(cross(z, along)) <= kRoundedOrientation)) return std::nullopt;
  return Pose{tcp.position, rotation_between(z, along) * tcp.rotation};
}

std::optional<Pose> nearest_reached(const RobotFacts& robot, const ik::InverseKinematics& arm,
                                    const Pose& tcp, const ik::IkExplanation& why) {
  if (!has_fewer_axes(robot.chain) || why.outcome != ik::IkOutcome::unreachable) return std::nullopt;
  ik::IkSolution at = why.nearest, there;
  if (arm.solve(tcp, ik::IkTask::position_only(), joints_of(robot, why.nearest), there) ==
      ik::IkOutcome::solved)
    at = there;
  const Pose out = robot.chain.forward(joints_of(robot, at));
  const bool near = norm(out.position - tcp.position) <= kRoundedPosition &&
                    angle_between(out.rotation, tcp.rotation) <= kRoundedOrientation;
  return near ? std::optional(out) : std::nullopt;
}

Pose reached_pose(const RobotFacts& robot, const Pose& tcp, std::span<const double> current) {
  if (!has_fewer_axes(robot.chain)) return tcp;
  std::optional<ik::InverseKinematics> own;
  const ik::InverseKinematics& arm = robot.solver ? *robot.solver : own.emplace(robot.chain);
  ik::IkSolution found;
  const std::optional<Pose> straight = straightened(robot, tcp);
  if (straight && arm.solve_move(*straight, current, robot.home, found) == ik::IkOutcome::solved &&
      found.exact)
    return *straight;
  if (arm.solve_move(tcp, current, robot.home, found) == ik::IkOutcome::solved)
    return found.exact ? tcp : robot.chain.forward(joints_of(robot, found));
  return nearest_reached(robot, arm, tcp, arm.explain(tcp, current)).value_or(tcp);
}

}  // namespace polyarm::moves
