#pragma once
/// What a user says a cell is: `cell.yaml`, or a ROS user's description with its controllers.
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/setup/door.hpp"
#include "polyarm/setup/recorder.hpp"
#include "polyarm/setup/safety_entries.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::ros_files {
struct ControllersFile;
}

namespace polyarm::cell {

/// How a robot's hardware runs on a thread of its own. What the machine refuses is told and does without.
struct ThreadEntry {
  int priority = 0;  ///< SCHED_FIFO priority; 0: ordinary
  int cpu = -1;      ///< processor; -1: any
  hardware::WhenLate overrun = hardware::WhenLate::report;
  unsigned overrun_after = 10;  ///< late runs or missed turns in a row
  bool operator==(const ThreadEntry&) const = default;
};

struct RobotEntry {
  std::string name = "arm";
  std::string model;              ///< catalogue name, or path of a description
  Pose base;                      ///< T_world_base; of one that is carried: at the start
  std::string on;                 ///< the robot whose root link carries it; empty: none
  std::string hardware = "mock";  ///< driver name, or "declared": what the description's <ros2_control> says
  std::string tool = "none";      ///< built-in tool, or path of a tool file
  std::string tip;                ///< the link that carries the tool; empty: RobotModel::tool_link's choice
  std::map<std::string, std::string> parameters;  ///< of the hardware
  Nanoseconds budget = 0;                         ///< of a read or write of its hardware in the loop; 0: any
  double rate = 0;                       ///< Hz at which its hardware and its controllers run; 0: the loop's
  bool thread = false;                   ///< its hardware has a thread of its own
  std::optional<ThreadEntry> on_thread;  ///< where it says how; over what its description says
  bool fault_of_group = false;  ///< `on_fault: group`: a fault of its hardware stops this robot alone
  std::map<std::string, std::string> arguments;  ///< NAME:=VALUE for a description in xacro
  bool accept_unverified = false;  ///< it may be armed although facts of it are recalled or estimated
  std::vector<moves::WorkspaceZone> workspace;  ///< of this robot alone
  PayloadEntry payload;                         ///< that it carries beside its tool
  std::vector<RangeEntry> ranges;               ///< of joints, narrower than the robot's
  std::string text;  ///< the description itself, where `model` names the file that it stands in
  Location where;
  std::map<std::string, Location> places;  ///< of its keys in the file
  /// Of a key, or of the robot where the file does not say it.
  const Location& place_of(const std::string& key) const {
    const auto at = places.find(key);
    return at == places.end() ? where : at->second;
  }
};

/// How long a joint move takes: as fast as the limits allow (times `speed`), or the thesis's rule.
struct MotionEntry {
  double speed = 1;                    ///< share of the limits, (0, 1]
  std::optional<double> seconds;       ///< every move takes at least this long
  std::optional<double> thesis_scale;  ///< s per rad of joint-space distance; limits still hold
  moves::TcpLimits tcp;                ///< of lines and arcs
  bool around = false;                 ///< joint moves go around obstacles unless the program says otherwise
};

/// How the control loop runs on the wall clock. What the machine refuses is told and does without.
struct LoopEntry {
  std::optional<int> priority;      ///< SCHED_FIFO priority of the control thread; 0: ordinary
  std::optional<int> cpu;           ///< processor of the control thread; -1: any
  std::optional<bool> lock_memory;  ///< by default with a priority
  control::Overrun overrun = control::Overrun::report;
  unsigned overrun_after = 10;  ///< late cycles in a row
  /// Half a second without cycles, or without the cell thread, holds what moves; by default where something
  /// is real.
  std::optional<bool> stall_holds;
};

/// A robot program or PLC file as the cell names it, and the folder beside which its files are looked for.
struct CellFile {
  std::filesystem::path path;    ///< of cell.yaml or the description
  std::filesystem::path folder;  ///< names in the cell are relative to it
  std::string name;
  double rate = 1000;        ///< Hz
  bool rate_stated = false;  ///< else the controllers' file may say another
  std::vector<RobotEntry> robots;
  std::string scene, signals, program, plc;  ///< file names as written; empty: none
  std::vector<std::string> controllers;      ///< files; a later one has the last word
  std::vector<std::pair<std::string, std::string>>
      send;                           ///< controller or topic → message file, at the start
  std::vector<std::string> activate;  ///< controllers to start; empty: all that can run together
  std::vector<std::string> plugins;   ///< folders with plugins, relative to the file
  Nanoseconds budget = 0;             ///< of a callback in the loop, where a robot says no other; 0: any
  Location scene_where, controllers_where, plugins_where, signals_where, program_where, plc_where;
  std::vector<std::string> notes;  ///< what was passed over on the way here, a sentence each
  std::shared_ptr<const ros_files::ControllersFile>
      launched;  ///< in place of `controllers`, from a launch file
  MotionEntry motion;
  LoopEntry loop;
  control::ContactStop contact_stop = control::ContactStop::path;  ///< what follows a contact in physics
  double clearance = kClearance;  ///< m that should stay between a robot and everything else
  ProfileEntries profiles;
  std::vector<moves::WorkspaceZone> workspace;   ///< of all robots
  std::map<std::string, DoorOptions> doors;      ///< into it, by the names of their modules
  std::optional<RecordOptions> record;           ///< each run is recorded
  /// What it may reach, as long as this file or a copy of it is somebody's.
  std::shared_ptr<ReachGrant> grant = reach().grant();
};

/// What the command line puts over the file.
struct Overrides {
  std::string robot;       ///< model for the only robot, or "name=model"
  std::string hardware;    ///< for every robot
  std::string program;     ///< a script, or a script-information file, beside the cell or anywhere
  Nanoseconds budget = 0;  ///< for everything; 0: what the file says
};

/// Reads `cell.yaml` (or the folder that has one). Throws Error with everything that is wrong.
CellFile read_cell_file(const std::filesystem::path& path, const Overrides& overrides = {});
/// A cell of one robot `arm` from a description file and, if given, its controllers YAMLs.
CellFile cell_from_description(const std::filesystem::path& description,
                               const std::vector<std::string>& controllers, const Overrides& overrides = {});

/// A cell of one robot `arm` from a launch file of ROS 1: its description, parameters and controllers; what
/// else it starts is noted. Packages are looked for above the file and beside it, in `package_folders`, and
/// where POLYARM_PACKAGES, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH say.
CellFile cell_from_launch(const std::filesystem::path& launch,
                          const std::map<std::string, std::string>& arguments, const Overrides& overrides,
                          Problems& problems);

}  // namespace polyarm::cell
