#include "polyarm/doctor/machine.hpp"

#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/device_lock.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/periodic.hpp"

extern "C" char** environ;

namespace polyarm::doctor {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream out;
  if (in) out << in.rdbuf();
  return out.str();
}

std::string first_line(const fs::path& file) {
  const std::string text = text_of(file);
  return std::string(trim(text.substr(0, text.find('\n'))));
}

std::vector<std::string> lines_of(const fs::path& file) {
  return split_words(text_of(file), "\r\n");
}

/// The text after `key` at the start of a line of /proc/self/status or limits.
std::string after(const std::vector<std::string>& lines, const std::string& key) {
  for (const std::string& line : lines)
    if (line.starts_with(key)) return std::string(trim(std::string_view(line).substr(key.size())));
  return {};
}

std::optional<std::int64_t> integer(const std::string& text) {
  const auto number = parse_number(text);
  if (!number || *number < -9e15 || *number > 9e15) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

/// The soft limit of a row of /proc/self/limits.
std::optional<std::int64_t> soft_limit(const std::vector<std::string>& limits, const std::string& row) {
  const std::vector<std::string> words = split_words(after(limits, row));
  if (words.empty()) return std::nullopt;
  if (words.front() == "unlimited") return std::numeric_limits<std::int64_t>::max();
  return integer(words.front());
}

void check_kernel(const fs::path& root, Machine& machine) {
  machine.kernel = first_line(root / "proc/sys/kernel/osrelease");
  machine.preempt_rt = first_line(root / "sys/kernel/realtime") == "1" ||
                       text_of(root / "proc/version").find("PREEMPT_RT") != std::string::npos;
  machine.rt_runtime_us = integer(first_line(root / "proc/sys/kernel/sched_rt_runtime_us"));
  machine.clock_source = first_line(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  std::error_code error;
  for (fs::directory_iterator at(root / "sys/devices/system/cpu", error), end; !error && at != end;
       at.increment(error))
    if (const std::string governor = first_line(at->path() / "cpufreq/scaling_governor"); !governor.empty())
      machine.governors[at->path().filename().string()] = governor;
}

void check_process(const Place& place, Machine& machine) {
  const std::vector<std::string> status = lines_of(place.root / "proc/self/status");
  const std::vector<std::string> ids = split_words(after(status, "Uid:"));
  machine.root_user = ids.size() > 1 && ids[1] == "0";
  constexpr int kSysNice = 23;  // CAP_SYS_NICE, linux/capability.h
  const std::string capabilities = after(status, "CapEff:");
  machine.may_schedule =
      !capabilities.empty() && ((std::strtoull(capabilities.c_str(), nullptr, 16) >> kSysNice) & 1);
  const std::vector<std::string> limits = lines_of(place.root / "proc/self/limits");
  if (const auto limit = soft_limit(limits, "Max realtime priority"))
    machine.rtprio_limit = static_cast<long>(std::min<std::int64_t>(*limit, 99));
  machine.memlock_limit = soft_limit(limits, "Max locked memory");
  for (const char* variable : {"USER", "LOGNAME"})
    if (const auto found = place.environment.find(variable);
        machine.user.empty() && found != place.environment.end())
      machine.user = found->second;
}

/// The lines of /etc/group, split.
std::vector<std::vector<std::string>> known_groups(const fs::path& root) {
  std::vector<std::vector<std::string>> out;
  for (const std::string& line : lines_of(root / "etc/group"))
    if (auto fields = split_fields(line, ':'); fields.size() >= 4) out.push_back(std::move(fields));
  return out;
}

void check_groups(const Place& place, Machine& machine) {
  const std::vector<std::string> status = lines_of(place.root / "proc/self/status");
  std::set<std::string> entered;
  for (const char* row : {"Gid:", "Groups:"})
    for (const std::string& id : split_words(after(status, row))) entered.insert(id);
  const auto known = known_groups(place.root);
  for (const char* name : {"dialout", "i2c", "realtime", "video"}) {
    Group group{name};
    for (const auto& fields : known) {
      if (fields[0] != name) continue;
      group.exists = true;
      group.entered = entered.contains(fields[2]);
      const auto members = split_words(fields[3], ",");
      group.listed = std::find(members.begin(), members.end(), machine.user) != members.end();
    }
    machine.groups.push_back(group);
  }
}

std::optional<Device> device_at(const Place& place, const std::string& path) {
  const fs::path file = place.root / path.substr(1);
  struct stat facts {};
  if (stat(file.c_str(), &facts) != 0) return std::nullopt;
  Device out{path, std::to_string(facts.st_gid), facts.st_mode & 07777u};
  for (const auto& fields : known_groups(place.root))
    if (fields[2] == out.group) {
      out.group = fields[0];
      break;
    }
  out.usable = access(file.c_str(), R_OK | W_OK) == 0;
  out.holder = hardware::DeviceLock::holder(file.string());
  return out;
}

/// Devices in /dev with these name prefixes, ordered by number.
std::vector<Device> devices(const Place& place, std::initializer_list<std::string_view> prefixes) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(place.root / "dev", error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    for (const std::string_view prefix : prefixes)
      if (name.starts_with(prefix)) names.push_back(name);
  }
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  std::vector<Device> out;
  for (const std::string& name : names)
    if (auto device = device_at(place, "/dev/" + name)) out.push_back(std::move(*device));
  return out;
}

/// Rows of /proc/net/tcp: "sl local_address rem_address st …", the address as hex "0100007F:1F90".
void listen_in(const fs::path& table, bool udp, std::vector<ListeningPort>& out) {
  for (const std::string& line : lines_of(table)) {
    const std::vector<std::string> words = split_words(line);
    if (words.size() < 4 || words[1].find(':') == std::string::npos) continue;
    if (words[3] != (udp ? "07" : "0A")) continue;  // unconnected, LISTEN
    const long number = std::strtol(words[1].substr(words[1].rfind(':') + 1).c_str(), nullptr, 16);
    if (number > 0 && number < 65536) out.push_back({static_cast<int>(number), udp});
  }
}

void check_environment(const Place& place, Machine& machine) {
  for (const char* variable :
       {"POLYARM_ROBOTS", "POLYARM_DRIVERS", "POLYARM_PACKAGES", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"}) {
    const auto found = place.environment.find(variable);
    if (found == place.environment.end()) continue;
    for (const std::string& path : split_words(found->second, ":")) {
      std::error_code error;
      const fs::path below = path.front() == '/' ? place.root / path.substr(1) : fs::path(path);
      machine.folders.push_back({variable, path, fs::is_directory(below, error)});
    }
  }
  for (const char* variable : {"ROS_DISTRO", "ROS_VERSION", "ROS_DOMAIN_ID", "ROS_LOCALHOST_ONLY",
                               "ROS_MASTER_URI", "RMW_IMPLEMENTATION"})
    if (const auto found = place.environment.find(variable);
        found != place.environment.end() && !found->second.empty())
      machine.ros[variable] = found->second;
}

}  // namespace

Place Place::here() {
  Place out;
  for (char** entry = environ; entry && *entry; ++entry) {
    const std::string text = *entry;
    if (const auto equals = text.find('='); equals != std::string::npos)
      out.environment[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return out;
}

Machine look_at(const Place& place) {
  Machine out;
  check_kernel(place.root, out);
  check_process(place, out);
  check_groups(place, out);
  out.serial_ports = devices(place, {"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS"});
  out.i2c_buses = devices(place, {"i2c-"});
  for (const char* table : {"tcp", "tcp6"}) listen_in(place.root / "proc/net" / table, false, out.listening);
  for (const char* table : {"udp", "udp6"}) listen_in(place.root / "proc/net" / table, true, out.listening);
  check_environment(place, out);
  return out;
}

Clock measure_clock(Nanoseconds duration) {
  Clock out;
  timespec resolution{};
  if (clock_getres(CLOCK_MONOTONIC, &resolution) == 0)
    out.resolution = static_cast<Nanoseconds>(resolution.tv_sec) * 1'000'000'000 + resolution.tv_nsec;
  constexpr Nanoseconds kPeriod = 1'000'000;
  realtime::Histogram late;
  realtime::Periodic clock(kPeriod);
  const Nanoseconds end = realtime::monotonic_now() + duration;
  clock.start();
  while (realtime::monotonic_now() < end) late.add(clock.wait().latency);
  out.late_p50 = late.percentile(0.5);
  out.late_p99 = late.percentile(0.99);
  out.late_max = late.max();
  out.wakeups = late.count();
  return out;
}

}  // namespace polyarm::doctor
