#include "polyarm/motion/robot_motion.hpp"

#include <fmt/format.h>

#include <cmath>

#include "polyarm/kinematics/inverse.hpp"

namespace polyarm::motion {

std::vector<double> joints_for(const RobotFacts& robot, const Pose& tcp, std::span<const double> current,
                               const std::string& what) {
  const kinematics::IkResult result =
      robot.solver ? robot.solver->solve_nearest(tcp, current, robot.home)
                   : kinematics::solve_nearest(robot.chain, tcp, current, robot.home);
  if (result.status == kinematics::IkStatus::solved) return result.q;
  throw Error(
      result.status == kinematics::IkStatus::limits ? "limit" : "unreachable",
      fmt::format("{} cannot be reached by {} ({}): {}", what, robot.name, robot.model->name, result.reason),
      "move the point, the robot's base, or choose a robot that reaches it");
}

void check_joints(const RobotFacts& robot, std::span<const double> joints, const std::string& what) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const double lower = robot.chain.lower()[j], upper = robot.chain.upper()[j];
    if (joints[j] >= lower - 1e-9 && joints[j] <= upper + 1e-9) continue;
    throw Error("limit",
                fmt::format("{} puts {} at {:.4f}, its limits are {:.4f} to {:.4f}", what,
                            robot.model->joint_names()[j], joints[j], lower, upper),
                std::abs(joints[j]) > 7 ? "this looks like degrees; joint values are radians"
                                        : "choose a value inside");
  }
}

std::uint64_t RobotMotion::move_to_joints(std::span<const double> target, const Pace& pace,
                                          const std::string& what) {
  check_joints(robot_, target, what);
  trajectory::JointMoveOptions options;
  options.speed_scale = pace.speed;
  if (pace.thesis_scale) options.duration = trajectory::thesis_duration(planned_, target, *pace.thesis_scale);
  if (pace.seconds) options.duration = *pace.seconds;
  auto goal = std::make_unique<controllers::TrajectoryGoal>();
  goal->id = controller_.new_goal_id();
  last_id_ = goal->id;
  goal->trajectory = trajectory::plan_joint_move(planned_, target, robot_.limits, options);
  last_duration_ = goal->trajectory.duration();
  if (!controller_.follow(goal))
    throw Error("busy", "the controller of " + robot_.name + " has not taken its last moves yet",
                "is the loop running?");
  planned_.assign(target.begin(), target.end());
  return last_id_;
}

std::uint64_t RobotMotion::move_to_pose(const Pose& tcp, const Pace& pace, const std::string& what) {
  return move_to_joints(joints_for(robot_, tcp, planned_, what), pace, what);
}

MoveState RobotMotion::state_of(std::uint64_t id) const {
  const controllers::GoalStatus& status = controller_.status();
  if (status.refused.load(std::memory_order_acquire) >= id) return MoveState::refused;
  if (status.discarded.load(std::memory_order_acquire) >= id) return MoveState::discarded;
  if (status.finished.load(std::memory_order_acquire) >= id) return MoveState::done;
  return MoveState::running;
}

}  // namespace polyarm::motion
