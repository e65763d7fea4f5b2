#pragma once
/// The robots of a cell, resolved from its files: model, tool, kinematics, limits, start state, driver.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "polyarm/ros_files/controllers_file.hpp"
#include "polyarm/ros_files/manager_parameters.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// The driver that simulates contacts.
inline constexpr const char* kPhysics = "mujoco";

/// One `<ros2_control>` block of a description and the driver that runs it.
struct HardwareBlock {
  const description::HardwareInfo* info = nullptr;
  std::string driver, flag;
};

/// One robot; its address does not change while the cell lives.
struct CellRobot {
  RobotEntry entry;
  description::RobotModel model;
  description::Tool tool;
  std::string driver;                           ///< driver of its joints
  std::vector<HardwareBlock> blocks;            ///< the blocks of its description with their drivers
  std::vector<double> start;                    ///< joint state at the start of a run
  std::vector<controllers::JointFacts> joints;  ///< actuated joints, full names
  std::unique_ptr<moves::RobotFacts> facts;
  /// Indices of the joints that the controllers of its base name: wheels and steering. Empty: none does.
  std::vector<int> wheel_joints;
  moves::Workspace slow_zones;           ///< beyond their boundaries the profile is reduced
  std::vector<Problem> hardware_faults;  ///< errors in its <ros2_control>; planning does not need hardware
};

/// Its tool and its payload together.
moves::Payload load_of(const CellRobot& robot);

/// A joint state of the robot, in its order: joints by name, with their units.
data::JointState joint_state(const description::RobotModel& model, std::vector<double> positions);

using CellRobots = std::vector<std::unique_ptr<CellRobot>>;

/// Real hardware that the cell's file or a description names, whether it is driven or simulated.
struct NamedHardware {
  std::string robot, component, driver;
  std::map<std::string, std::string> parameters;
};
std::vector<NamedHardware> named_real_hardware(const CellRobots& robots);

/// Loads models and tools and chooses drivers. Drivers of real hardware are used only if `real`; otherwise a
/// simulation replaces them. Adds problems with their locations; a robot that cannot be loaded is left out.
/// `notes` gets one line per replaced component. `described`: the controllers' files, for limits and wheels.
CellRobots resolve_robots(const CellFile& file, const ros_files::ControllersFile& described,
                          const description::Catalogue& catalogue, bool real, Problems& problems,
                          std::vector<std::string>& notes);
/// The same for callers that have not read the controllers' files; reads only their limits and wheels.
CellRobots resolve_robots(const CellFile& file, const description::Catalogue& catalogue, bool real,
                          Problems& problems, std::vector<std::string>& notes);

/// One sentence for each robot that has several arms: how each arm becomes a robot of its own.
std::vector<std::string> notes_of_arms(const CellRobots& robots);

/// Adds the errors in the robots' <ros2_control>: as errors if the hardware must run, as warnings if only
/// kinematics is needed.
void add_hardware_faults(const CellRobots& robots, Severity as, Problems& problems);

/// The name of physics, which is one component: that of the first <ros2_control> whose joints it simulates.
/// It also answers to the names of the others. "mujoco" if it also simulates a robot without <ros2_control>.
std::string physics_name(const CellRobots& robots);
/// A <ros2_control> that physics simulates. Blocks of several robots may have the same name.
struct PlayedBlock {
  const CellRobot* robot;
  const description::HardwareInfo* info;
};
std::vector<PlayedBlock> played_by_physics(const CellRobots& robots);
/// All names of a component, each once: its own, or those that physics simulates.
std::vector<std::string> names_of_component(const CellRobots& robots, const std::string& component);

/// Adds the components: one per block of a description, with the block's name; everything in physics is one
/// component, because it is one world. Physics gets the scene if there is any. `initial` says which
/// components stay unconfigured or inactive at the start; those of real hardware are at most inactive until
/// they are armed. Real hardware in lock-step is an error.
void add_components(hardware::Hardware& hardware, const CellRobots& robots, const description::Scene& scene,
                    Nanoseconds period, bool lock_step, const ros_files::ManagerParameters& manager,
                    Problems& problems);

/// True if reading from the driver's device blocks, so it needs a thread of its own.
bool waits_for_a_device(const std::string& driver);
/// True if all hardware of the robot runs on threads of its own, which may have any rate.
bool on_threads(const CellRobot& robot);
/// Number of loop cycles between updates of a robot's controllers, and of its hardware without a thread; 1 if
/// its entry states no rate. A rate that does not divide the loop's is a problem without threads; with
/// threads the controllers run at the next higher rate that does.
unsigned divisor_of(const CellRobot& robot, Nanoseconds period, Problems& problems);

/// A rebuilt component that will replace the one with its name, and the data that it was built from.
struct Remade {
  CellRobots robots;  ///< must live as long as the component
  Problems warnings;
  std::unique_ptr<hardware::Component> component;
  hardware::ComponentContext context;
};

/// Reads the descriptions again and builds the named component from them. Does not access the running cell
/// except `scene`, whose address it keeps: any thread, one call at a time. Throws Error if a file has errors
/// or no robot declares the component any more.
Remade make_again(const std::string& name, const CellFile& file, const description::Catalogue& catalogue,
                  bool real, const description::Scene& scene, Nanoseconds period);

}  // namespace polyarm::cell
