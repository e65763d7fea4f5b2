#pragma once
/// The robots of a cell as everything else needs them: model, tool, kinematics, limits, home, driver.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/cell/cell_file.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/catalogue.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/motion/robot_motion.hpp"

namespace polyarm::cell {

/// One robot; stays where it is in memory while the cell lives.
struct CellRobot {
  RobotEntry entry;
  description::RobotModel model;
  description::Tool tool;
  std::string driver;
  std::vector<double> start;                    ///< joint state at the start of a run
  std::vector<controllers::JointFacts> joints;  ///< actuated joints, whole names
  std::unique_ptr<motion::RobotFacts> facts;
};

using CellRobots = std::vector<std::unique_ptr<CellRobot>>;

/// Loads models and tools and picks drivers. Problems are added with their places; a robot that cannot be had
/// is left out. `notes` gets one line for every replaced component.
CellRobots resolve_robots(const CellFile& file, const description::Catalogue& catalogue, Problems& problems,
                          std::vector<std::string>& notes);

/// Adds one component for each driver, which then stands for all robots that use it. The scene goes to the
/// driver that simulates physics where there is one.
void add_components(hardware::Hardware& hardware, const CellRobots& robots, const description::Scene& scene,
                    Nanoseconds period);

}  // namespace polyarm::cell
