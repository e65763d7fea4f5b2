#pragma once
/// Starts the controllers of a cell, and finds the ones that move a robot.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/control/control_loop.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/controllers_plan.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::cell {

/// Loads and configures the planned controllers, starting with those that others are chained to, and starts
/// those that can run together. Reports each one that stays inactive. If `activate` names a controller that
/// is not planned, that is an error unless `described` has it: then it was left out with a warning. Adds its
/// findings to the problems. Returns the chosen controllers, including those whose hardware is missing: they
/// start when it is armed.
std::vector<std::string> start_controllers(std::vector<PlannedController> plan, const CellFile& file,
                                           const ros_files::ControllersFile& described,
                                           const CellRobots& robots, control::ControlLoop& loop,
                                           Observer& observer, Problems& problems);

/// The active controller that follows trajectories of all joints of the robot in the model's order; null if
/// there is none. `or_inactive`: also accepts a configured controller, because it starts when the robot is
/// armed.
controllers::JointTrajectoryController* trajectory_controller_of(const CellRobot& robot,
                                                                 const control::ControllerManager& manager,
                                                                 bool or_inactive = false);

/// The controller that drives the wheels of the robot; null if none.
controllers::BaseController* base_controller_of(const CellRobot& robot,
                                                const control::ControllerManager& manager);

/// A warning of code late-wheels if `controller` drives joints of a robot that were no wheels when the cell
/// started: bodies and bases are made then. Empty otherwise.
std::optional<Problem> late_wheels(const std::string& controller, const CellRobots& robots,
                                   const control::ControllerManager& manager);

}  // namespace polyarm::cell
