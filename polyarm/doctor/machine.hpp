#pragma once
/// Collects the properties of a machine that matter to Polyarm, from files and the environment. Changes
/// nothing; needs no root rights.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"

namespace polyarm::doctor {

/// Where to read from. Everything comes from files below `root`, except the access rights to devices.
struct Place {
  std::filesystem::path root = "/";
  std::map<std::string, std::string> environment;
  static Place here();  ///< this machine and this process
};

/// A device file.
struct Device {
  std::string path;
  std::string group;    ///< its owner group; a number if the group has no name
  unsigned mode = 0;    ///< permission bits
  bool usable = false;  ///< this process may read and write it
  std::string holder;   ///< the Polyarm process that uses it, as it describes itself; empty: none
};

/// A TCP or UDP port with a listener, on this machine only or on all its addresses.
struct ListeningPort {
  int number = 0;
  bool udp = false;
};

struct Group {
  std::string name;
  bool exists = false;
  bool entered = false;  ///< this process is a member
  bool listed = false;   ///< the user becomes a member at the next login
};

/// A folder from an environment variable.
struct NamedFolder {
  std::string variable, path;
  bool exists = false;
};

struct Machine {
  std::string kernel;  ///< release; empty: unknown
  bool preempt_rt = false;
  bool root_user = false;     ///< has all rights
  bool may_schedule = false;  ///< has CAP_SYS_NICE
  std::string user;
  std::optional<long> rtprio_limit;              ///< 0: none; empty: unknown
  std::optional<std::int64_t> memlock_limit;     ///< bytes; max(): unlimited
  std::optional<std::int64_t> rt_runtime_us;     ///< of each second, for real-time threads; -1: all
  std::map<std::string, std::string> governors;  ///< "cpu0" → "powersave"; empty if not readable
  std::string clock_source;
  std::vector<Group> groups;
  std::vector<Device> serial_ports, i2c_buses;
  std::vector<ListeningPort> listening;
  std::vector<NamedFolder> folders;        ///< POLYARM_…, ROS_PACKAGE_PATH, AMENT_PREFIX_PATH
  std::map<std::string, std::string> ros;  ///< ROS variables that are set
};

/// Never throws: values that cannot be read stay empty.
Machine look_at(const Place& place);

/// Properties of the clock: its resolution, and the wake-up delay of a thread with a period of one
/// millisecond.
struct Clock {
  Nanoseconds resolution = 0;
  Nanoseconds late_p50 = 0, late_p99 = 0, late_max = 0;
  std::uint64_t wakeups = 0;
};
/// Blocks for `duration`.
Clock measure_clock(Nanoseconds duration);

}  // namespace polyarm::doctor
