#pragma once
/// The user's definition of a cell: `cell.yaml`, or a ROS description with its controllers.
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/hardware/force_sensor.hpp"
#include "polyarm/io/stream_entries.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/setup/belts.hpp"
#include "polyarm/setup/door.hpp"
#include "polyarm/setup/recorder.hpp"
#include "polyarm/setup/safety_entries.hpp"
#include "polyarm/teleop/settings.hpp"

namespace polyarm::ros_files {
struct ControllersFile;
}

namespace polyarm::cell {

/// Options of a hardware thread. Options that the machine refuses are reported and ignored.
struct ThreadEntry {
  int priority = 0;  ///< SCHED_FIFO priority; 0: normal scheduling
  int cpu = -1;      ///< CPU index; -1: any
  hardware::WhenLate overrun = hardware::WhenLate::report;
  unsigned overrun_after = 10;  ///< late runs or missed turns in a row
  bool operator==(const ThreadEntry&) const = default;
};

struct RobotEntry {
  std::string name = "arm";
  std::string model;              ///< catalogue name, or path of a description
  Pose base;                      ///< T_world_base; for a carried robot: at the start
  std::string on;                 ///< the robot whose root link carries it; empty: none
  std::string hardware = "mock";  ///< driver name, or "declared": that of the description's <ros2_control>
  std::string tool = "none";      ///< built-in tool, or path of a tool file
  std::string tip;                ///< link that carries the tool; empty: chosen by RobotModel::tool_link()
  std::string branch;             ///< a link of the arm that it is; empty: the whole description
  std::map<std::string, std::string> parameters;  ///< of the hardware
  Nanoseconds budget = 0;                         ///< per read or write in the loop, ns; 0: unlimited
  double rate = 0;                       ///< Hz, for its hardware and its controllers; 0: the loop's rate
  bool thread = false;                   ///< its hardware runs on a thread of its own
  std::optional<ThreadEntry> on_thread;  ///< thread options, if stated; override those of the description
  bool fault_of_group = false;           ///< `on_fault: group`: a fault of its hardware stops only this robot
  std::map<std::string, std::string> arguments;  ///< NAME:=VALUE for a description in xacro
  bool accept_unverified = false;  ///< may be armed although some of its facts are recalled or estimated
  std::vector<moves::WorkspaceZone> workspace;  ///< of this robot only
  PayloadEntry payload;                         ///< in addition to its tool
  std::vector<RangeEntry> ranges;               ///< joint ranges narrower than the robot's
  std::string calibration;    ///< file with the measured geometry of the arm; empty: that of the description
  bool force_sensor = false;  ///< physics measures the wrench between robot and tool
  hardware::ForceSensorErrors sensor_errors;
  std::vector<CollisionTorqueEntry> collision_torques;
  std::string text;           ///< the description itself, if `model` is the file that contains it
  Location where;
  std::map<std::string, Location> places;  ///< of its keys in the file
  /// Location of a key, or of the robot if the file does not have the key.
  const Location& place_of(const std::string& key) const {
    const auto at = places.find(key);
    return at == places.end() ? where : at->second;
  }
};

/// Duration of a joint move: as short as the limits allow (scaled by `speed`), or the thesis's rule.
struct MotionEntry {
  double speed = 1;                    ///< share of the limits, (0, 1]
  std::optional<double> seconds;       ///< every move takes at least this long
  std::optional<double> thesis_scale;  ///< s per rad of joint-space distance; limits still hold
  moves::TcpLimits tcp;                ///< of lines and arcs
  bool around = false;                 ///< joint moves go around obstacles unless the program says otherwise
};

/// Options of the control loop on the wall clock. Options that the machine refuses are reported and ignored.
struct LoopEntry {
  std::optional<int> priority;      ///< SCHED_FIFO priority of the control thread; 0: normal scheduling
  std::optional<int> cpu;           ///< CPU of the control thread; -1: any
  std::optional<bool> lock_memory;  ///< default: true if a priority is set
  control::Overrun overrun = control::Overrun::report;
  unsigned overrun_after = 10;  ///< late cycles in a row
  /// True: half a second without cycles, or without the cell thread, holds the robots. Default: true if any
  /// component is real.
  std::optional<bool> stall_holds;
};

/// The contents of a cell file.
struct CellFile {
  std::filesystem::path path;    ///< of cell.yaml or of the description
  std::filesystem::path folder;  ///< names in the cell are relative to it
  std::string name;
  double rate = 1000;        ///< Hz
  bool rate_stated = false;  ///< false: the controllers' file may define the rate
  std::vector<RobotEntry> robots;
  std::string scene, signals, program, plc;  ///< file names as written; empty: none
  std::vector<std::string> controllers;      ///< files; later ones take precedence
  std::vector<std::pair<std::string, std::string>>
      send;                           ///< controller or topic → message file, sent at the start
  std::vector<std::string> activate;  ///< controllers to start; empty: all that can run together
  std::vector<std::string> plugins;   ///< folders with plugins, relative to the file
  Nanoseconds budget = 0;             ///< default limit of a callback in the loop, ns; 0: unlimited
  Location scene_where, controllers_where, plugins_where, signals_where, program_where, plc_where;
  std::vector<std::string> notes;  ///< skipped parts of the files, one sentence each
  std::shared_ptr<const ros_files::ControllersFile>
      launched;  ///< from a launch file, instead of `controllers`
  MotionEntry motion;
  LoopEntry loop;
  std::uint64_t seed = 0;                                          ///< of the programs' random()
  control::ContactStop contact_stop = control::ContactStop::path;  ///< what follows a contact in physics
  double clearance = kClearance;  ///< m that should stay between a robot and everything else
  GuardsEntry guards;             ///< what stops robots before contacts
  std::vector<BeltEntry> belts;
  std::vector<StreamEntry> streams;
  ProfileEntries profiles;
  std::vector<moves::WorkspaceZone> workspace;  ///< for all robots
  std::vector<teleop::PairSettings> teleop;     ///< robots that lead others
  std::map<std::string, DoorOptions> doors;     ///< by module name
  std::optional<RecordOptions> record;          ///< set: record each run
  /// What the cell may access; valid as long as this object or a copy exists.
  std::shared_ptr<ReachGrant> grant = reach().grant();
};

/// Options of the command line that override the file.
struct Overrides {
  std::string robot;       ///< model for the only robot, or "name=model"
  std::string hardware;    ///< for every robot
  std::string program;     ///< a script or script-information file, beside the cell or elsewhere
  Nanoseconds budget = 0;  ///< for all callbacks; 0: as in the file
};

/// Reads `cell.yaml` (or the one in this folder). Throws Error that lists all problems found.
CellFile read_cell_file(const std::filesystem::path& path, const Overrides& overrides = {});
/// A cell of one robot `arm` from a description file and, if given, its controllers YAMLs.
CellFile cell_from_description(const std::filesystem::path& description,
                               const std::vector<std::string>& controllers, const Overrides& overrides = {});

/// A cell with one robot `arm` from a ROS 1 launch file: its description, parameters and controllers; other
/// nodes are noted. Packages are searched above and beside the file, in `package_folders`, and in
/// POLYARM_PACKAGES, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
CellFile cell_from_launch(const std::filesystem::path& launch,
                          const std::map<std::string, std::string>& arguments, const Overrides& overrides,
                          Problems& problems);

}  // namespace polyarm::cell
