#pragma once
/// What is known of a robot of a cell when it is moved.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/torque_limits.hpp"
#include "polyarm/moves/workspace.hpp"
#include "polyarm/trajectory/joint_move.hpp"

namespace polyarm::moves {

/// How the TCP moves on lines, arcs and splines where a move does not say otherwise: m, rad, s. No standard
/// or maker states these; they are about what small industrial arms are run at.
struct TcpLimits {
  double speed = 1, acceleration = 5, jerk = 50;
  double turn_speed = 3, turn_acceleration = 15, turn_jerk = 150;
};

/// What a robot needs to move: its kinematics with tool, limits, workspace and home. Const while the cell
/// runs.
struct RobotFacts {
  std::string name;
  const description::RobotModel* model = nullptr;
  kinematics::Chain chain;  ///< TCP in the world over the actuated joints
  std::vector<trajectory::JointMotionLimits> limits;
  TcpLimits tcp;
  std::vector<double> home;
  /// For `chain`; if null, each question makes its own.
  std::unique_ptr<const ik::InverseKinematics> solver;
  Workspace workspace;  ///< where the TCP may be
  /// What the joints can bring, with tool and load; null where nothing is known to judge by.
  std::shared_ptr<const TorqueLimits> torques;
};

/// The same robot with another TCP.
std::shared_ptr<const RobotFacts> with_chain(const RobotFacts& robot, kinematics::Chain chain);

/// Where a pose puts the joints, coming from `current`: within limits, in the configuration nearest to the
/// present one, ranked from home. Throws Error("unreachable" | "limit") that says which distance, angle or
/// joint is at fault; `what` names the point.
std::vector<double> joints_for(const RobotFacts& robot, const Pose& tcp_in_world,
                               std::span<const double> current, const std::string& what);
/// Checks a joint state against the limits. Throws Error("limit") naming joint, value and limit.
void check_joints(const RobotFacts& robot, std::span<const double> joints, const std::string& what);

}  // namespace polyarm::moves
