#pragma once
/// The data of one robot of a cell that moves need. Metres, radians, seconds.
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

/// Limits of the TCP on lines, arcs and splines for moves that state none: m, rad, s. No standard and no
/// maker defines these values; they are typical for small industrial arms.
struct TcpLimits {
  double speed = 1, acceleration = 5, jerk = 50;
  double turn_speed = 3, turn_acceleration = 15, turn_jerk = 150;
};

/// The data needed to move a robot: kinematics with tool, limits, workspace and home. Const while the cell
/// runs.
struct RobotFacts {
  std::string name;
  const description::RobotModel* model = nullptr;
  kinematics::Chain chain;  ///< TCP in the world over the actuated joints
  std::vector<trajectory::JointMotionLimits> limits;
  TcpLimits tcp;
  std::vector<double> home;
  /// For `chain`; if null, each query makes its own.
  std::unique_ptr<const ik::InverseKinematics> solver;
  Workspace workspace;  ///< where the TCP may be
  /// The torques that the joints can provide, with tool and load; null if the data are missing.
  std::shared_ptr<const TorqueLimits> torques;
};

/// The same robot with another TCP.
std::shared_ptr<const RobotFacts> with_chain(const RobotFacts& robot, kinematics::Chain chain);

/// The joint state for a pose: within limits, and in the configuration nearest to `current`; ties are ranked
/// by distance from home. Throws Error("unreachable" | "limit") that states the distance, angle or joint at
/// fault; `what` names the point.
std::vector<double> joints_for(const RobotFacts& robot, const Pose& tcp_in_world,
                               std::span<const double> current, const std::string& what);
/// Throws Error("limit") with joint, value and limit if a joint state violates a limit.
void check_joints(const RobotFacts& robot, std::span<const double> joints, const std::string& what);

}  // namespace polyarm::moves
