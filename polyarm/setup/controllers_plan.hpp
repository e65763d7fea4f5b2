#pragma once
/// Which controllers a cell has: what its files say, or a sensible set.
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

/// Name of the controller that carries tags to command interfaces.
inline constexpr const char* kIoController = "io";

/// All that the cell's controller files say, or what its launch file said. Empty where there are none. What
/// is wrong joins the problems; throws Error where nothing can be read at all.
ros_files::ControllersFile read_cell_controllers(const CellFile& file, Problems& problems);

/// The control rate, Hz: the cell's, or what its controllers files say where the cell states none.
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
  std::vector<std::string> io_commands;  ///< command interfaces that tags are carried to
  bool lock_step = false;
  Nanoseconds budget = 0;  ///< of each controller; 0: none
};

/// The controllers that are described, or where none of them moves anything a trajectory controller for each
/// robot; a joint state broadcaster where there is none, and one that carries tags out.
std::vector<PlannedController> plan_controllers(const ros_files::ControllersFile& described,
                                                const CellRobots& robots, control::ControlLoop& loop,
                                                const PlanOptions& options, Observer& observer,
                                                Problems& problems);

}  // namespace polyarm::cell
