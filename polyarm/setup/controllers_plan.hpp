#pragma once
/// Selects the controllers of a cell: those of its files, or a default set.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/control/control_loop.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/ros_files/controllers_file.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// Name of the controller that writes tags to command interfaces.
inline constexpr const char* kIoController = "io";

/// The contents of the cell's controllers' files, or of its launch file; empty without any. Errors are added
/// to the problems; throws Error if nothing can be read.
ros_files::ControllersFile read_cell_controllers(const CellFile& file, Problems& problems);

/// The control rate, Hz: the cell's, or that of its controllers' files if the cell states none.
double rate_of(const CellFile& file, const ros_files::ControllersFile& described);

struct PlannedController {
  std::unique_ptr<controllers::Controller> controller;
  controllers::ControllerContext context;
  control::LoadOptions options;
  bool start = true;
};

/// Hands the robots' models to a controller that needs kinematics. The robots outlive its configuration.
void hand_models(controllers::Controller& controller, const CellRobots& robots);

struct PlanOptions {
  std::vector<std::string> io_commands;  ///< command interfaces that tags drive
  bool lock_step = false;
  Nanoseconds budget = 0;  ///< of each controller, ns; 0: unlimited
};

/// The described controllers. If none of them moves anything, a trajectory controller for each robot. Adds a
/// joint state broadcaster if there is none, and the controller for tags.
std::vector<PlannedController> plan_controllers(const ros_files::ControllersFile& described,
                                                const CellRobots& robots, control::ControlLoop& loop,
                                                const PlanOptions& options, Observer& observer,
                                                Problems& problems);

}  // namespace polyarm::cell
