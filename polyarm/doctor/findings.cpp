#include "polyarm/doctor/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "polyarm/base/text.hpp"

namespace polyarm::doctor {

const char* name(Grade grade) {
  switch (grade) {
    case Grade::ok:
      return "ok";
    case Grade::note:
      return "note";
    case Grade::problem:
      return "problem";
  }
  return "?";
}

const char* name(Concern concern) {
  switch (concern) {
    case Concern::simulation:
      return "simulation";
    case Concern::hardware:
      return "hardware";
    case Concern::real_time:
      return "real time";
  }
  return "?";
}

namespace {

using Findings = std::vector<Finding>;
constexpr const char* kLimitsFile = "/etc/security/limits.d/99-realtime.conf";

void judge_kernel(const Machine& m, Findings& out) {
  const std::string kernel = m.kernel.empty() ? "of unknown release" : m.kernel;
  if (m.preempt_rt)
    out.push_back({Grade::ok, Concern::real_time, "kernel", kernel + ", PREEMPT_RT", ""});
  else
    out.push_back(
        {Grade::note, Concern::real_time, "kernel",
         kernel + ", without PREEMPT_RT: good for simulation and slow buses, a 1 kHz robot may be late",
         "uname -v  # install a kernel with PREEMPT_RT (Debian: sudo apt install linux-image-rt-amd64; "
         "Ubuntu: sudo pro enable realtime-kernel)"});
  if (m.rt_runtime_us && *m.rt_runtime_us >= 0 && *m.rt_runtime_us < 950'000)
    out.push_back({Grade::note, Concern::real_time, "kernel",
                   fmt::format("real-time threads get only {} ms of each second", *m.rt_runtime_us / 1000),
                   "sudo sysctl kernel.sched_rt_runtime_us=950000"});
}

void judge_limits(const Machine& m, Findings& out) {
  const std::string set_up = fmt::format(
      "sudo groupadd -f realtime && sudo usermod -aG realtime $USER && printf '@realtime - rtprio 95\\n"
      "@realtime - memlock unlimited\\n' | sudo tee {}  # then log out and in",
      kLimitsFile);
  if (m.root_user || m.may_schedule)
    out.push_back({Grade::ok, Concern::real_time, "priority", "any real-time priority may be taken", ""});
  else if (!m.rtprio_limit)
    out.push_back(
        {Grade::note, Concern::real_time, "priority", "the limit of priorities cannot be read", ""});
  else if (*m.rtprio_limit == 0)
    out.push_back({Grade::note, Concern::real_time, "priority",
                   "no real-time priority may be taken (--priority will be refused)", set_up});
  else
    out.push_back({Grade::ok, Concern::real_time, "priority",
                   fmt::format("real-time priorities up to {} may be taken", *m.rtprio_limit), ""});
  constexpr std::int64_t kEnough = 512ll << 20;
  if (m.root_user || (m.memlock_limit && *m.memlock_limit >= kEnough))
    out.push_back({Grade::ok, Concern::real_time, "memory", "a whole cell may be locked into memory", ""});
  else if (m.memlock_limit)
    out.push_back({Grade::note, Concern::real_time, "memory",
                   fmt::format("only {} MiB may be locked into memory", *m.memlock_limit >> 20), set_up});
}

void judge_governors(const Machine& m, Findings& out) {
  std::map<std::string, int> count;
  for (const auto& [cpu, governor] : m.governors) ++count[governor];
  for (const auto& [governor, cpus] : count) {
    const std::string text =
        fmt::format("{} of {} processors: governor {}", cpus, m.governors.size(), governor);
    if (governor == "performance")
      out.push_back({Grade::ok, Concern::real_time, "processors", text, ""});
    else
      out.push_back({Grade::note, Concern::real_time, "processors", text + ", clocks fall when idle",
                     "sudo cpupower frequency-set -g performance"});
  }
  if (!m.clock_source.empty() && (m.clock_source == "hpet" || m.clock_source == "acpi_pm"))
    out.push_back({Grade::note, Concern::real_time, "clock",
                   "the clock source is " + m.clock_source + ", which is slow to read",
                   "dmesg | grep -i clocksource  # shows why the kernel rejected the processor's own clock"});
}

const char* purpose(const std::string& group) {
  if (group == "dialout") return "serial ports";
  if (group == "i2c") return "I2C buses";
  if (group == "realtime") return "priorities without root";
  return "cameras and graphics";
}

void judge_groups(const Machine& m, Findings& out) {
  if (m.root_user) {
    out.push_back({Grade::note, Concern::hardware, "groups",
                   "this is root, which needs no group; a cell does not need root",
                   "exit  # and run Polyarm as an ordinary user"});
    return;
  }
  for (const Group& group : m.groups) {
    const std::string join = "sudo usermod -aG " + group.name + " $USER  # then log out and in";
    if (!group.exists)
      out.push_back({Grade::note, Concern::hardware, "groups",
                     fmt::format("there is no group {} ({})", group.name, purpose(group.name)),
                     "sudo groupadd -f " + group.name + " && " + join});
    else if (group.entered)
      out.push_back({Grade::ok, Concern::hardware, "groups",
                     fmt::format("in {} ({})", group.name, purpose(group.name)), ""});
    else if (group.listed)
      out.push_back({Grade::note, Concern::hardware, "groups",
                     fmt::format("{} takes effect at the next login", group.name),
                     "newgrp " + group.name + "  # or log out and in"});
    else
      out.push_back({Grade::note, Concern::hardware, "groups",
                     fmt::format("not in {} ({})", group.name, purpose(group.name)), join});
  }
}

void judge_device(const Machine& m, const Device& device, const char* topic, const char* usual_group,
                  Findings& out) {
  const std::string facts = fmt::format("{} (group {}, mode {:03o})", device.path, device.group, device.mode);
  if (!device.holder.empty())
    out.push_back({Grade::note, Concern::hardware, topic, facts + " is in use by " + device.holder, ""});
  else if (device.usable)
    out.push_back({Grade::ok, Concern::hardware, topic, facts, ""});
  else {
    const bool group_may = (device.mode & 060) == 060 && device.group != "root" && device.group != "0";
    const std::string join = "sudo usermod -aG " + (group_may ? device.group : usual_group) + " $USER";
    const std::string rule = fmt::format(
        "echo 'KERNEL==\"{}\", GROUP=\"{}\", MODE=\"0660\"' | sudo tee /etc/udev/rules.d/99-polyarm.rules && "
        "sudo udevadm trigger && ",
        device.path.substr(device.path.rfind('/') + 1), usual_group);
    out.push_back({Grade::problem, Concern::hardware, topic, facts + " may not be opened",
                   (group_may ? "" : rule) + join + "  # then log out and in"});
  }
}

void judge_devices(const Machine& m, Findings& out) {
  for (const Device& device : m.serial_ports) judge_device(m, device, "serial port", "dialout", out);
  if (m.serial_ports.empty())
    out.push_back({Grade::note, Concern::hardware, "serial port", "none",
                   "sudo dmesg | tail  # after plugging an adapter in"});
  for (const Device& device : m.i2c_buses) judge_device(m, device, "I2C bus", "i2c", out);
  if (m.i2c_buses.empty())
    out.push_back({Grade::note, Concern::hardware, "I2C bus", "none",
                   "sudo modprobe i2c-dev  # on a Raspberry Pi: sudo raspi-config nonint do_i2c 0"});
}

/// A port that robots and tools use to reach a cell.
struct KnownPort {
  int number;
  bool udp;
  const char* use;
};
constexpr KnownPort kPorts[] = {
    {502, false, "Modbus"},         {6510, true, "ABB EGM"},         {8765, false, "Foxglove"},
    {9090, false, "rosbridge"},     {30001, false, "UR primary"},    {30002, false, "UR secondary"},
    {30003, false, "UR real time"}, {30004, false, "UR RTDE"},       {50001, false, "UR external control"},
    {50002, false, "UR script"},    {50003, false, "UR trajectory"}, {59152, true, "KUKA RSI"},
};

void judge_ports(const Machine& m, Findings& out) {
  bool any = false;
  for (const KnownPort& port : kPorts) {
    const bool taken = std::any_of(m.listening.begin(), m.listening.end(), [&](const ListeningPort& l) {
      return l.number == port.number && l.udp == port.udp;
    });
    if (!taken) continue;
    any = true;
    out.push_back({Grade::note, Concern::hardware, "network",
                   fmt::format("{} port {} ({}) is taken by a program on this machine",
                               port.udp ? "UDP" : "TCP", port.number, port.use),
                   fmt::format("ss -{}lnp 'sport = :{}'", port.udp ? 'u' : 't', port.number)});
  }
  if (!any)
    out.push_back(
        {Grade::ok, Concern::hardware, "network", "no port that robots and tools use is taken", ""});
}

void judge_environment(const Machine& m, Findings& out) {
  for (const NamedFolder& folder : m.folders)
    if (folder.exists)
      out.push_back({Grade::ok, Concern::simulation, "folders", folder.variable + ": " + folder.path, ""});
    else
      out.push_back({Grade::note, Concern::simulation, "folders",
                     folder.variable + " names " + folder.path + ", which is not a folder",
                     "unset " + folder.variable + "  # or name one that exists"});
  std::vector<std::string> set;
  for (const auto& [variable, value] : m.ros) set.push_back(variable + "=" + value);
  out.push_back({set.empty() ? Grade::ok : Grade::note, Concern::simulation, "ROS",
                 set.empty() ? "no ROS environment; Polyarm needs none"
                             : join(set, " ") + ": not needed; packages of AMENT_PREFIX_PATH are found",
                 ""});
}

}  // namespace

Findings judge(const Machine& machine) {
  Findings out;
  judge_kernel(machine, out);
  judge_limits(machine, out);
  judge_governors(machine, out);
  judge_groups(machine, out);
  judge_devices(machine, out);
  judge_ports(machine, out);
  judge_environment(machine, out);
  return out;
}

Findings judge(const Clock& clock) {
  const auto us = [](Nanoseconds t) { return static_cast<double>(t) * 1e-3; };
  Findings out;
  if (clock.resolution > 1000)
    out.push_back(
        {Grade::problem, Concern::real_time, "clock",
         fmt::format("the clock counts in steps of {:g} us, a control loop needs 1 us", us(clock.resolution)),
         "dmesg | grep -i hres  # boot without nohz=off and highres=off"});
  else
    out.push_back(
        {Grade::ok, Concern::real_time, "clock", fmt::format("resolution {} ns", clock.resolution), ""});
  const std::string late = fmt::format(
      "{} wake-ups, one each 1 ms, were late by {:.0f} us (half), {:.0f} us (99 %), {:.0f} us (most)",
      clock.wakeups, us(clock.late_p50), us(clock.late_p99), us(clock.late_max));
  const bool fine = clock.late_p99 < 500'000;
  out.push_back({fine ? Grade::ok : Grade::note, Concern::real_time, "clock", late,
                 fine ? "" : "top  # end what keeps the processors busy, or run with --priority 80 --cpu N"});
  return out;
}

Findings judge(const Installation& here) {
  Findings out;
  const std::string folders = join(here.catalogue_folders, ", ");
  if (here.robots > 0 && here.catalogue_error.empty())
    out.push_back({Grade::ok, Concern::simulation, "catalogue",
                   fmt::format("{} robots in {}", here.robots, folders), ""});
  else
    out.push_back({Grade::problem, Concern::simulation, "catalogue",
                   here.catalogue_error.empty() ? "no robots are found" : here.catalogue_error,
                   "export POLYARM_ROBOTS=/path/to/robots"});
  out.push_back(
      {Grade::ok, Concern::simulation, "drivers", "looked for in " + join(here.driver_folders, ", "), ""});
  for (const Installation::Module& module : here.modules) {
    const bool physics = module.name == "mujoco";
    const Concern concern = physics ? Concern::simulation : Concern::hardware;
    if (module.found && module.fault.empty())
      out.push_back({Grade::ok, concern, "drivers", module.name, ""});
    else if (module.found)
      out.push_back(
          {Grade::problem, concern, "drivers", module.name + " cannot be loaded: " + module.fault,
           physics ? "sudo apt install libmujoco-dev" : "cmake --build build/release --target drivers"});
    else
      out.push_back(
          {Grade::note, concern, "drivers",
           module.name + (physics ? " is not here: cells run on the mock, without physics" : " is not here"),
           std::string(physics ? "sudo apt install libmujoco-dev && " : "") +
               "cmake --build build/release --target drivers"});
  }
  for (const std::string& cell : here.cells)
    out.push_back({Grade::note, Concern::hardware, "cells", "the cell " + cell + " is running", ""});
  return out;
}

Findings judge(const Disk& disk) {
  constexpr std::int64_t kRecording = 1ll << 30, kBlackBox = 100ll << 20;
  const std::string text = fmt::format("{} MiB free in {}", disk.free_bytes >> 20, disk.folder);
  const std::string mend = "du -xh --max-depth=2 '" + disk.folder + "' | sort -h | tail";
  if (disk.free_bytes >= kRecording) return {{Grade::ok, Concern::simulation, "disk", text, ""}};
  if (disk.free_bytes >= kBlackBox)
    return {{Grade::note, Concern::simulation, "disk", text + ": little for recordings", mend}};
  return {
      {Grade::problem, Concern::simulation, "disk", text + ": not enough for the records of a fault", mend}};
}

bool may_simulate(const Findings& findings) {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.grade == Grade::problem && finding.concern == Concern::simulation;
  });
}

}  // namespace polyarm::doctor
