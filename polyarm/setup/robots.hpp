#pragma once
/// The robots of a cell as everything else needs them: model, tool, kinematics, limits, home, driver.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "polyarm/ros_files/manager_parameters.hpp"
#include "polyarm/ros_files/parameter_file.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// The driver that simulates contacts.
inline constexpr const char* kPhysics = "mujoco";

/// One `<ros2_control>` of a description and what plays it.
struct HardwareBlock {
  const description::HardwareInfo* info = nullptr;
  std::string driver, flag;
};

/// One robot; stays where it is in memory while the cell lives.
struct CellRobot {
  RobotEntry entry;
  description::RobotModel model;
  description::Tool tool;
  std::string driver;                           ///< of its joints
  std::vector<HardwareBlock> blocks;            ///< what its description declares, each with its driver
  std::vector<double> start;                    ///< joint state at the start of a run
  std::vector<controllers::JointFacts> joints;  ///< actuated joints, whole names
  std::unique_ptr<moves::RobotFacts> facts;
  std::vector<Problem> hardware_faults;  ///< errors in its <ros2_control>; planning does without hardware
};

using CellRobots = std::vector<std::unique_ptr<CellRobot>>;

/// Real hardware that the cell's file or a description names, whether it is driven or played by something
/// simulated.
struct NamedHardware {
  std::string robot, component, driver;
  std::map<std::string, std::string> parameters;
};
std::vector<NamedHardware> named_real_hardware(const CellRobots& robots);

/// Loads models and tools and picks drivers. Drivers of real hardware are taken where `real` says so, else
/// something simulated plays their part, which a note tells. Problems are added with their places; a robot
/// that cannot be had is left out. `notes` gets one line for every replaced component. `limits`: those of the
/// controllers' files.
CellRobots resolve_robots(const CellFile& file, const std::vector<ros_files::JointLimitsSource>& limits,
                          const description::Catalogue& catalogue, bool real, Problems& problems,
                          std::vector<std::string>& notes);
/// The same for who has not read the controllers' files; they are read for their limits alone.
CellRobots resolve_robots(const CellFile& file, const description::Catalogue& catalogue, bool real,
                          Problems& problems, std::vector<std::string>& notes);

/// Adds the faults in the robots' <ros2_control>: as errors where the hardware is to run, as warnings where
/// only kinematics is asked for.
void add_hardware_faults(const CellRobots& robots, Severity as, Problems& problems);

/// Physics is one component, whatever it plays: it is named as the first <ros2_control> whose joints it
/// plays, and answers to the names of all of them. "mujoco" where a robot without <ros2_control> is played,
/// too.
std::string physics_name(const CellRobots& robots);
/// A <ros2_control> that physics plays. Those of several robots may have one name.
struct PlayedBlock {
  const CellRobot* robot;
  const description::HardwareInfo* info;
};
std::vector<PlayedBlock> played_by_physics(const CellRobots& robots);
/// The names that a component answers to, each once: its own, or those of what physics plays.
std::vector<std::string> names_of_component(const CellRobots& robots, const std::string& component);

/// Adds the components: one for each block that a description declares, named as the block; all that physics
/// plays is one component, since it is one world. The scene goes to physics where there is some. `initial`
/// says which components stay unconfigured or inactive at the start; those of real hardware are at most
/// inactive, until somebody arms them. Real hardware in lock-step is an error.
void add_components(hardware::Hardware& hardware, const CellRobots& robots, const description::Scene& scene,
                    Nanoseconds period, bool lock_step, const ros_files::ManagerParameters& manager,
                    Problems& problems);

/// True if reading from the driver's device blocks, so it needs a thread of its own.
bool waits_for_a_device(const std::string& driver);
/// Has all hardware of the robot a thread of its own, which may run at any rate?
bool on_threads(const CellRobot& robot);
/// Every how many cycles of a loop of this period the controllers of a robot run whose entry states a rate,
/// and its hardware where it has no thread; 1 where it states none. A rate that is no part of the loop's is a
/// problem without threads; with them the controllers run at the next higher rate that is.
unsigned divisor_of(const CellRobot& robot, Nanoseconds period, Problems& problems);

/// A component that is to take the place of the one that runs under its name, and what it is made from.
struct Remade {
  CellRobots robots;  ///< have to live as long as the component
  Problems warnings;
  std::unique_ptr<hardware::Component> component;
  hardware::ComponentContext context;
};

/// Reads the descriptions again and makes the named component from them. Touches nothing of a running cell
/// but `scene`, whose address it keeps: any thread, one at a time. Throws Error where something is wrong with
/// a file, or no robot declares it any more.
Remade make_again(const std::string& name, const CellFile& file, const description::Catalogue& catalogue,
                  bool real, const description::Scene& scene, Nanoseconds period);

}  // namespace polyarm::cell
