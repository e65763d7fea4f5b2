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
#include "polyarm/motion/robot_facts.hpp"

namespace polyarm::motion {

/// How fast a move goes.
struct Pace {
  double speed = 1;                    ///< share of the limits
  std::optional<double> seconds;       ///< at least this long
  std::optional<double> thesis_scale;  ///< duration = scale × joint-space distance, limits permitting
};

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
