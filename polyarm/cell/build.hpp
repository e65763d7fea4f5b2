#pragma once
/// The steps of building a cell from its files.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/cell/cell_file.hpp"
#include "polyarm/cell/data_files.hpp"
#include "polyarm/cell/observer.hpp"
#include "polyarm/cell/robots.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/controllers/diff_drive_controller.hpp"
#include "polyarm/controllers/joint_trajectory_controller.hpp"
#include "polyarm/program/parser.hpp"
#include "polyarm/ros_files/controllers_file.hpp"

namespace polyarm::cell {

/// Name of the controller that carries tags to command interfaces.
inline constexpr const char* kIoController = "io";

/// Loads the plugins of the cell's folders and of those that are looked through by default. What cannot be
/// used becomes a warning.
void load_plugins(const CellFile& file, Problems& problems);

/// The control rate: the cell's, or what its controllers file says where the cell comes from a description.
double rate_of(const CellFile& file, Problems& problems);

/// All that the cell's controller files say, or what its launch file said. Empty where there are none.
ros_files::ControllersFile read_cell_controllers(const CellFile& file, Problems& problems);

struct PlannedController {
  std::unique_ptr<controllers::Controller> controller;
  controllers::ControllerContext context;
  control::LoadOptions options;
  bool start = true;
};
struct ControllerPlan {
  std::vector<PlannedController> controllers;
  ros_files::ManagerParameters manager;
};

/// The controllers of the cell's files, or a sensible set where it has none: a trajectory controller for each
/// robot, a joint state broadcaster, and one that carries the tags in `io_commands` out.
ControllerPlan plan_controllers(const CellFile& file, const CellRobots& robots, control::ControlLoop& loop,
                                const std::vector<std::string>& io_commands, bool lock_step,
                                Observer& observer, Problems& problems);
/// Loads and configures the planned controllers, those that others are chained to first, and starts what can
/// run together; who has to stay inactive is told. What is wrong joins the problems. Returns those that were
/// chosen, also where their hardware is not there yet: they are to start when it is armed.
std::vector<std::string> start_controllers(ControllerPlan plan, const CellFile& file,
                                           const CellRobots& robots, control::ControlLoop& loop,
                                           Observer& observer, Problems& problems);

/// The active controller that follows trajectories of all joints of the robot in the model's order; null if
/// none. `or_inactive`: one that is configured will do, since it is started when the robot is armed.
controllers::JointTrajectoryController* trajectory_controller_of(const CellRobot& robot,
                                                                 const control::ControllerManager& manager,
                                                                 bool or_inactive = false);

/// The controller that drives the wheels of the robot; null if none.
controllers::DiffDriveController* base_controller_of(const CellRobot& robot,
                                                     const control::ControllerManager& manager);

struct Programs {
  std::optional<program::Program> program, plc;
};

/// Loads the program (a script, or a script-information file whose files are followed), its data and the PLC,
/// and checks them against the names of the store, which `more_names` may add to when the data are there.
Programs load_programs(const CellFile& file, DataFiles& files, data::DataStore& store, Problems& problems,
                       const std::function<void()>& more_names = {}, const program::ReadPrograms& read = {});

}  // namespace polyarm::cell
