#pragma once
/// The configuration that a cell is built from: file, options, robots and scene. Constant while the cell
/// runs.
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/ros_files/controllers_file.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/cell_options.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

struct CellSetup {
  CellFile file;
  CellOptions options;
  description::Catalogue catalogue;
  ros_files::ManagerParameters manager;  ///< the manager's parameters from the controllers' file
  CellRobots robots;
  std::vector<CellRobots> reloaded;  ///< robots that reloaded components refer to
  description::Scene scene;
  std::vector<Problem> unchecked_bodies;  ///< bodies whose contacts are not detected
};

/// Reads plugins, controllers, robots and scene of `setup.file` into the setup. Sends notes to the observer.
/// Throws Error that lists all problems found.
ros_files::ControllersFile read_setup(CellSetup& setup, Observer& observer, Problems& problems);

}  // namespace polyarm::cell
