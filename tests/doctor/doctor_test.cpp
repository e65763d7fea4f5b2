#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "polyarm/doctor/findings.hpp"
#include "polyarm/hardware/device_lock.hpp"

namespace polyarm::doctor {
namespace {

namespace fs = std::filesystem;

/// A machine made of files.
class Files {
 public:
  Files() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_XXXXXX").string();
    place.root = ::mkdtemp(pattern.data());
  }
  ~Files() {
    std::error_code ignored;
    fs::remove_all(place.root, ignored);
  }
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((place.root / path).parent_path());
    std::ofstream(place.root / path) << text;
  }
  Machine look() const { return look_at(place); }

  Place place;
};

/// Findings of a topic that have a grade.
std::vector<Finding> of(const std::vector<Finding>& all, const std::string& topic, Grade grade) {
  std::vector<Finding> out;
  for (const Finding& finding : all)
    if (finding.topic == topic && finding.grade == grade) out.push_back(finding);
  return out;
}

TEST(Doctor, ReadsLimitsKernelAndProcessors) {
  Files files;
  files.write("proc/sys/kernel/osrelease", "6.8.1-rt8\n");
  files.write("sys/kernel/realtime", "1\n");
  files.write("proc/self/limits",
              "Limit                     Soft Limit           Hard Limit           Units     \n"
              "Max locked memory         8388608              8388608              bytes     \n"
              "Max realtime priority     95                   99                             \n");
  files.write("proc/self/status", "Name:\tx\nUid:\t1000\t1000\t1000\t1000\nCapEff:\t0000000000000000\n");
  files.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  files.write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  const Machine machine = files.look();
  EXPECT_EQ(machine.kernel, "6.8.1-rt8");
  EXPECT_TRUE(machine.preempt_rt);
  EXPECT_FALSE(machine.root_user);
  EXPECT_FALSE(machine.may_schedule);
  EXPECT_EQ(machine.rtprio_limit, 95);
  EXPECT_EQ(machine.memlock_limit, 8388608);
  const auto findings = judge(machine);
  EXPECT_EQ(of(findings, "kernel", Grade::ok).size(), 1u);
  EXPECT_EQ(of(findings, "priority", Grade::ok).size(), 1u);
  EXPECT_EQ(of(findings, "memory", Grade::note).size(), 1u);
  ASSERT_EQ(of(findings, "processors", Grade::note).size(), 1u);
  EXPECT_NE(of(findings, "processors", Grade::note)[0].text.find("1 of 2"), std::string::npos);
}

TEST(Doctor, UnlimitedMemoryIsUnlimited) {
  Files files;
  files.write("proc/self/limits", "Max locked memory         unlimited  unlimited  bytes\n");
  EXPECT_EQ(of(judge(files.look()), "memory", Grade::ok).size(), 1u);
}

TEST(Doctor, TellsGroupsThatAreEnteredListedAndMissing) {
  Files files;
  files.place.environment["USER"] = "ada";
  files.write("etc/group", "root:x:0:\ndialout:x:20:\ni2c:x:998:bob,ada\nvideo:x:44:bob\n");
  files.write("proc/self/status", "Uid:\t1000\t1000\nGid:\t1000\t1000\nGroups:\t20 1000 \n");
  const auto findings = judge(files.look());
  ASSERT_EQ(of(findings, "groups", Grade::ok).size(), 1u);
  EXPECT_NE(of(findings, "groups", Grade::ok)[0].text.find("dialout"), std::string::npos);
  const auto notes = of(findings, "groups", Grade::note);
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_NE(notes[0].text.find("next login"), std::string::npos);
  EXPECT_NE(notes[1].text.find("no group realtime"), std::string::npos);
  EXPECT_NE(notes[2].mend.find("usermod -aG video"), std::string::npos);
}

TEST(Doctor, FindsDevicesInOrderAndWhoHoldsThem) {
  Files files;
  files.write("etc/group", "dialout:x:" + std::to_string(getgid()) + ":\n");
  for (const char* name : {"ttyUSB10", "ttyUSB2", "ttyACM0", "tty1", "i2c-1", "null"})
    files.write(std::string("dev/") + name, "");
  ASSERT_EQ(::chmod((files.place.root / "dev/ttyUSB2").c_str(), 0660), 0);
  const hardware::DeviceLock lock((files.place.root / "dev/ttyUSB2").string(), "the cell lab");
  const Machine machine = files.look();
  ASSERT_EQ(machine.serial_ports.size(), 3u);
  EXPECT_EQ(machine.serial_ports[0].path, "/dev/ttyACM0");
  EXPECT_EQ(machine.serial_ports[1].path, "/dev/ttyUSB2");
  EXPECT_EQ(machine.serial_ports[1].group, "dialout");
  EXPECT_EQ(machine.serial_ports[1].mode, 0660u);
  EXPECT_NE(machine.serial_ports[1].holder.find("the cell lab"), std::string::npos);
  EXPECT_EQ(machine.serial_ports[2].path, "/dev/ttyUSB10");
  EXPECT_EQ(machine.serial_ports[2].holder, "");
  ASSERT_EQ(machine.i2c_buses.size(), 1u);
  const auto notes = of(judge(machine), "serial port", Grade::note);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].text.find("in use by the cell lab"), std::string::npos);
}

TEST(Doctor, ADeviceThatMayNotBeOpenedIsAProblemOfHardwareWithItsCommand) {
  Machine machine;
  machine.serial_ports = {{"/dev/ttyUSB0", "dialout", 0660, false, ""}};
  machine.i2c_buses = {{"/dev/i2c-1", "root", 0600, false, ""}};
  const auto findings = judge(machine);
  const auto port = of(findings, "serial port", Grade::problem),
             bus = of(findings, "I2C bus", Grade::problem);
  ASSERT_EQ(port.size(), 1u);
  EXPECT_EQ(port[0].mend, "sudo usermod -aG dialout $USER  # then log out and in");
  ASSERT_EQ(bus.size(), 1u);
  EXPECT_NE(bus[0].mend.find("KERNEL==\"i2c-1\", GROUP=\"i2c\""), std::string::npos);
  EXPECT_TRUE(may_simulate(findings));
}

TEST(Doctor, PortsThatListenAreFoundAndOthersPassedOver) {
  Files files;
  files.write("proc/net/tcp",
              "  sl  local_address rem_address   st tx_queue rx_queue\n"
              "   0: 0100007F:223D 00000000:0000 0A 00000000:00000000\n"    // 8765, listening
              "   1: 0100007F:2382 0100007F:9C40 01 00000000:00000000\n");  // 9090, a connection
  files.write("proc/net/udp", "   0: 00000000:196E 00000000:0000 07 00000000:00000000\n");  // 6510
  const auto notes = of(judge(files.look()), "network", Grade::note);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_NE(notes[0].text.find("UDP port 6510"), std::string::npos);
  EXPECT_NE(notes[1].text.find("TCP port 8765 (Foxglove)"), std::string::npos);
}

TEST(Doctor, FoldersThatAreNotThereAndRosAreNoted) {
  Files files;
  fs::create_directories(files.place.root / "opt/ros/humble");
  files.place.environment = {{"AMENT_PREFIX_PATH", "/opt/ros/humble:/gone"}, {"ROS_DISTRO", "humble"}};
  const auto findings = judge(files.look());
  EXPECT_EQ(of(findings, "folders", Grade::ok).size(), 1u);
  ASSERT_EQ(of(findings, "folders", Grade::note).size(), 1u);
  EXPECT_NE(of(findings, "folders", Grade::note)[0].text.find("/gone"), std::string::npos);
  ASSERT_EQ(of(findings, "ROS", Grade::note).size(), 1u);
}

TEST(Doctor, AnEmptyOrGarbledMachineIsNoCrash) {
  Files files;
  EXPECT_TRUE(may_simulate(judge(files.look())));
  for (const char* path :
       {"proc/self/limits", "proc/self/status", "etc/group", "proc/net/tcp", "proc/net/udp6"})
    files.write(path, std::string("Max realtime priority\nUid:\n::::\n: : :0 0A\nGroups: x\n\0\xff:", 53));
  EXPECT_TRUE(may_simulate(judge(files.look())));
}

TEST(Doctor, EveryProblemNamesACommand) {
  Machine bad;
  bad.serial_ports = {{"/dev/ttyUSB0", "0", 0600, false, ""}};
  bad.i2c_buses = {{"/dev/i2c-0", "i2c", 0660, false, ""}};
  Installation nothing;
  nothing.modules = {{"mujoco", true, "libmujoco.so is missing"}, {"serial_imu", true, "?"}};
  Clock coarse;
  coarse.resolution = 4'000'000;
  std::vector<Finding> all;
  for (const auto& part : {judge(bad), judge(nothing), judge(coarse), judge(Disk{"/var", 1000})})
    all.insert(all.end(), part.begin(), part.end());
  int problems = 0;
  for (const Finding& finding : all)
    if (finding.grade == Grade::problem) {
      ++problems;
      EXPECT_FALSE(finding.mend.empty()) << finding.text;
    }
  EXPECT_EQ(problems, 7);
}

TEST(Doctor, OnlyProblemsOfSimulationStandInItsWay) {
  EXPECT_FALSE(may_simulate(judge(Installation{})));
  Installation fine;
  fine.robots = 3;
  fine.modules = {{"mujoco", false, ""}, {"serial_imu", true, "a symbol is missing"}};
  EXPECT_TRUE(may_simulate(judge(fine)));
  EXPECT_FALSE(may_simulate(judge(Disk{"/", 10 << 20})));
  EXPECT_TRUE(may_simulate(judge(Disk{"/", 500 << 20})));
}

TEST(Doctor, TheClockIsMeasured) {
  const Clock clock = measure_clock(20'000'000);
  EXPECT_GT(clock.wakeups, 0u);
  EXPECT_GE(clock.late_max, clock.late_p99);
  EXPECT_GT(clock.resolution, 0);
}

}  // namespace
}  // namespace polyarm::doctor
