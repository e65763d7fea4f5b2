#pragma once
/// What a machine is like, as far as it matters to Polyarm: read from files and the environment, nothing
/// changed, no root needed.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"

namespace polyarm::doctor {

/// Where to look. Everything but who may open a device comes from files below `root`.
struct Place {
  std::filesystem::path root = "/";
  std::map<std::string, std::string> environment;
  static Place here();  ///< this machine and this process
};

/// A device file.
struct Device {
  std::string path;
  std::string group;    ///< that owns it; a number where it has no name
  unsigned mode = 0;    ///< permission bits
  bool usable = false;  ///< this process may read and write it
  std::string holder;   ///< the Polyarm process that has it, in its own words; empty: none
};

/// A TCP or UDP port that something listens on, on this machine alone or on all its addresses.
struct ListeningPort {
  int number = 0;
  bool udp = false;
};

struct Group {
  std::string name;
  bool exists = false;
  bool entered = false;  ///< this process has it
  bool listed = false;   ///< the user is a member from the next login on
};

/// A folder that an environment variable names.
struct NamedFolder {
  std::string variable, path;
  bool exists = false;
};

struct Machine {
  std::string kernel;  ///< release; empty: unknown
  bool preempt_rt = false;
  bool root_user = false;     ///< may do anything
  bool may_schedule = false;  ///< has CAP_SYS_NICE
  std::string user;
  std::optional<long> rtprio_limit;              ///< 0: none; empty: unknown
  std::optional<std::int64_t> memlock_limit;     ///< bytes; max(): unlimited
  std::optional<std::int64_t> rt_runtime_us;     ///< of each second that real-time threads get; -1: all
  std::map<std::string, std::string> governors;  ///< "cpu0" → "powersave"; empty where not readable
  std::string clock_source;
  std::vector<Group> groups;
  std::vector<Device> serial_ports, i2c_buses;
  std::vector<ListeningPort> listening;
  std::vector<NamedFolder> folders;        ///< POLYARM_…, ROS_PACKAGE_PATH, AMENT_PREFIX_PATH
  std::map<std::string, std::string> ros;  ///< variables of ROS that are set
};

/// Never throws: what cannot be read is left out.
Machine look_at(const Place& place);

/// What the clock does: its resolution, and how late a thread wakes up that asks for every millisecond.
struct Clock {
  Nanoseconds resolution = 0;
  Nanoseconds late_p50 = 0, late_p99 = 0, late_max = 0;
  std::uint64_t wakeups = 0;
};
/// Takes as long as it says.
Clock measure_clock(Nanoseconds duration);

}  // namespace polyarm::doctor
