#pragma once
/// From "move there" to a trajectory handed to a controller.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/controllers/joint_trajectory_controller.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/arm_solver.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/trajectory/joint_move.hpp"

namespace polyarm::motion {

/// What a robot needs to move: its kinematics with tool, limits and home. Const while the cell runs.
struct RobotFacts {
  std::string name;
  const description::RobotModel* model = nullptr;
  kinematics::Chain chain;  ///< TCP in the world over the actuated joints
  std::vector<trajectory::JointMotionLimits> limits;
  std::vector<double> home;
  /// Of `chain`; where there is none, each question makes its own.
  std::unique_ptr<const kinematics::ArmSolver> solver;
};

/// How fast a move goes.
struct Pace {
  double speed = 1;                    ///< share of the limits
  std::optional<double> seconds;       ///< at least this long
  std::optional<double> thesis_scale;  ///< duration = scale × joint-space distance, limits permitting
};

/// Where a pose puts the joints, coming from `current`: within limits, in the configuration nearest to the
/// present one, ranked from home. Throws Error("unreachable" | "limit") that says which distance, angle or
/// joint is at fault; `what` names the point.
std::vector<double> joints_for(const RobotFacts& robot, const Pose& tcp_in_world,
                               std::span<const double> current, const std::string& what);
/// Checks a joint state against the limits. Throws Error("limit") naming joint, value and limit.
void check_joints(const RobotFacts& robot, std::span<const double> joints, const std::string& what);

enum class MoveState { running, done, discarded, refused };

/// Moves of one robot, one after the other. Cell thread only.
class RobotMotion {
 public:
  RobotMotion(const RobotFacts& robot, controllers::JointTrajectoryController& controller)
      : robot_(robot), controller_(controller) {}

  /// Starts a move from where the robot was last sent. Returns its id. Throws Error when the target cannot be
  /// had or the controller's inbox is full.
  std::uint64_t move_to_joints(std::span<const double> target, const Pace& pace, const std::string& what);
  std::uint64_t move_to_pose(const Pose& tcp_in_world, const Pace& pace, const std::string& what);
  MoveState state_of(std::uint64_t id) const;

  /// Where the robot was last sent, or is commanded to be; moves start here.
  const std::vector<double>& planned() const { return planned_; }
  /// Tells where the robot is commanded to be, after start-up or a discarded move.
  void set_planned(std::span<const double> joints) { planned_.assign(joints.begin(), joints.end()); }
  /// True when the last move is over, however it ended.
  bool idle() const { return last_id_ == 0 || state_of(last_id_) != MoveState::running; }
  double last_duration() const { return last_duration_; }
  const RobotFacts& robot() const { return robot_; }

 private:
  const RobotFacts& robot_;
  controllers::JointTrajectoryController& controller_;
  std::vector<double> planned_;
  std::uint64_t last_id_ = 0;
  double last_duration_ = 0;
};

}  // namespace polyarm::motion
