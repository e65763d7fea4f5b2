#pragma once
/// What a move_group answers: plans, inverse and forward kinematics, Cartesian paths, validity of states.
/// Each takes milliseconds to seconds and allocates: not on the cell thread. Failures are codes of MoveIt
/// with a sentence.
#include <functional>
#include <optional>
#include <string>

#include "polyarm/move_group/scene.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::move_group {

struct PlanSettings {
  double clearance = 0;             ///< m; less where start or goal are nearer to something
  moves::MovePlanOptions limits;    ///< of all moves of the cell
  std::function<bool()> cancelled;  ///< asked now and then; null: never
};

/// The longest time of one request, s, and of one that states none.
inline constexpr double kLongestPlanning = 60, kUsualPlanning = 5;
inline constexpr std::size_t kMostWaypoints = 5000, kMostTrajectoryPoints = 20'000;

msg::MotionPlanResponse plan(const Around& around, const msg::MotionPlanRequest& request,
                             const PlanSettings& settings);
srv::GetPositionIK::Response solve_ik(const Around& around, const msg::PositionIKRequest& request,
                                      const PlanSettings& settings);
srv::GetPositionFK::Response solve_fk(const Around& around, const srv::GetPositionFK::Request& request);
srv::GetStateValidity::Response validity(const Around& around, const srv::GetStateValidity::Request& request);
srv::GetCartesianPath::Response cartesian_path(const Around& around,
                                               const srv::GetCartesianPath::Request& request,
                                               const PlanSettings& settings);

/// Why a trajectory cannot be carried out from here: names, numbers, or a contact on the way. `from`: the
/// first point that counts. Throws Refusal.
void check_trajectory(const Around& around, const msg::RobotTrajectory& trajectory, std::size_t from = 0);
/// Throws Refusal(CONTROL_FAILED) if the robot is not where the trajectory begins.
void check_start(const Around& around, const msg::RobotTrajectory& trajectory);

/// The joints of a robot state, over the present ones. Objects that it attaches are in `around` afterwards.
void take_state(const msg::RobotState& state, Around& around);

}  // namespace polyarm::move_group
