/// A driver in a process of its own comes to harm; the drives tell what becomes of the joints.
#include "drivers/cia402/watchdog.hpp"

#include <thread>

#include "drivers/cia402/sdo.hpp"
#include "tests/cia402/rig.hpp"
#include "tests/support/driving_process.hpp"

namespace polyarm::test {
namespace {

using cia402::FarDrive;
using cia402::Machine;

class Driven : public ::testing::Test {
 protected:
  void drive(std::vector<std::string> parameters) {
    parameters.insert(parameters.begin(), {POLYARM_FAKE_PROCESS, far.path()});
    process = std::make_unique<DrivingProcess>(parameters);
    ASSERT_EQ(process->line(), "driving\n");
    ASSERT_TRUE(becomes([](FarDrive& drive) { return drive.enabled() && drive.angle() > 0.01; }));
  }
  /// False after a minute.
  template <typename Is>
  bool becomes(Is is) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < end) {
      const bool all = far.with([&](Machine& machine) {
        return std::all_of(machine.drives().begin(), machine.drives().end(), is);
      });
      if (all) return true;
      std::this_thread::yield();
    }
    return false;
  }
  bool stand() {
    return becomes([](FarDrive& drive) { return std::string(drive.state_name()) == "quick stop active"; });
  }
  FarSide far{two_drives()};
  std::unique_ptr<DrivingProcess> process;
};

using Cia402Watchdog = Driven;

TEST_F(Cia402Watchdog, KilledDrivesThatWatchTheHeartbeatStopByThemselves) {
  drive({});
  process->signal(SIGKILL);
  EXPECT_TRUE(stand());
  far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_EQ(drive.value(0x603F), 0x8130u);
    return 0;
  });
}

TEST_F(Cia402Watchdog, KilledTheProcessStopsDrivesThatDoNotWatch) {
  far.order("unwatched=1");
  far.order("unwatched=2");
  drive({});
  process->signal(SIGKILL);
  EXPECT_TRUE(stand());
  far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) {
      EXPECT_EQ(drive.value(0x603F), 0u) << "it did not stop by itself";
      EXPECT_FALSE(drive.written(0x6040).empty()) << "the process ordered it by SDO";
    }
    return 0;
  });
}

TEST_F(Cia402Watchdog, FrozenTheDrivesStopAndStaySoWhenItContinues) {
  drive({});
  process->signal(SIGSTOP);
  ASSERT_TRUE(stand());
  process->signal(SIGCONT);
  const std::string line = process->line();
  EXPECT_NE(line.find("missed the heartbeat of this computer"), std::string::npos) << line;
  far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_FALSE(drive.enabled()) << "nothing enabled it again";
    return 0;
  });
  process->tell("activate");
  EXPECT_EQ(process->line(), "driving\n");
}

TEST_F(Cia402Watchdog, ContinuingEnablesNoDriveThatHasStoppedByItself) {
  // These take commands at once when the process continues: a target and "enable" would start them again.
  far.order("stays=1");
  far.order("stays=2");
  drive({});
  process->signal(SIGSTOP);
  ASSERT_TRUE(stand());
  const auto before = far.with([](Machine& machine) { return machine.q(); });
  const auto enabling = [&] {
    const auto frames = far.heard();
    return std::count_if(frames.begin(), frames.end(), [](const cia402::CanFrame& frame) {
      return frame.id >> 7 == 4 && frame.data[0] == 0x0F;
    });
  };
  const auto sent = enabling();
  process->signal(SIGCONT);
  const std::string line = process->line();
  EXPECT_NE(line.find("missed the heartbeat of this computer"), std::string::npos) << line;
  EXPECT_EQ(far.with([](Machine& machine) { return machine.q(); }), before);
  EXPECT_EQ(enabling(), sent) << "no target was sent to them after the pause";
}

TEST_F(Cia402Watchdog, FrozenTheProcessStopsDrivesThatDoNotWatch) {
  far.order("unwatched=1");
  far.order("unwatched=2");
  drive({});
  process->signal(SIGSTOP);
  ASSERT_TRUE(stand());
  process->signal(SIGCONT);
  const std::string line = process->line();
  EXPECT_NE(line.find("this process did not run for more than 1000 ms"), std::string::npos) << line;
  far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_FALSE(drive.enabled()) << "nothing enabled it again";
    return 0;
  });
}

TEST_F(Cia402Watchdog, EndedAsItShouldNothingIsLeftToWatch) {
  drive({});
  process->tell("return");
  process->wait();
  ASSERT_TRUE(stand());
  far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) {
      EXPECT_EQ(drive.value(0x1016, 1), 0u);
      EXPECT_EQ(drive.value(0x603F), 0u);
    }
    return 0;
  });
}

TEST(Cia402WatchdogWords, ThereAndBack) {
  cia402::WatchdogSettings settings{"/dev/ttyACM0", 50, 250, 60'000, {1, 2, 127}};
  std::vector<std::string> words = cia402::words_of(settings);
  words.insert(words.begin(), cia402::kWatchdogProgram);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  cia402::WatchdogSettings read;
  ASSERT_TRUE(cia402::settings_from(static_cast<int>(argv.size()), argv.data(), read));
  EXPECT_EQ(read.bus, settings.bus);
  EXPECT_EQ(read.nodes, settings.nodes);
  EXPECT_EQ(read.timeout_ms, 250);
  EXPECT_FALSE(cia402::settings_from(5, argv.data(), read)) << "no nodes";
  std::string wrong = "200";
  argv.back() = wrong.data();
  EXPECT_FALSE(cia402::settings_from(static_cast<int>(argv.size()), argv.data(), read)) << "no such node";
}

}  // namespace
}  // namespace polyarm::test
