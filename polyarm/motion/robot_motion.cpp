#include "polyarm/motion/robot_motion.hpp"

#include <fmt/format.h>

#include <cmath>

#include "polyarm/kinematics/inverse.hpp"

namespace polyarm::motion {

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
