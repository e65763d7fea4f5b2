#pragma once
/// What a cell is built from: its file, options, robots and scene. It does not change while the cell runs.
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
  ros_files::ManagerParameters manager;  ///< what the controllers' files say of their manager
  CellRobots robots;
  std::vector<CellRobots> reloaded;  ///< what components that were reloaded refer to
  description::Scene scene;
  std::vector<Problem> unchecked_bodies;  ///< bodies whose contacts nothing detects
};

/// Reads plugins, controllers, robots and scene of `setup.file` into the setup. Notes go to the observer.
/// Throws Error with everything that is wrong in any file.
ros_files::ControllersFile read_setup(CellSetup& setup, Observer& observer, Problems& problems);

}  // namespace polyarm::cell
