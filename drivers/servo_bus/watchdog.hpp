#pragma once
/// What the watchdog (drivers/watchdog) does to a bus: most servos keep their last speed for ever.
#include <string>
#include <vector>

#include "drivers/servo_bus/standstill.hpp"

namespace polyarm::servo_bus {

inline constexpr const char* kServoWatchdog = "polyarm_servo_watchdog";

struct WatchdogSettings {
  std::string family = {}, port = {};  ///< the port is open already; its name is for whoever lists processes
  int baud = 0, answer_ms = 0;
  int timeout_ms = 0;  ///< without a heartbeat
  int give_up_ms = 60'000;
  std::vector<StandingJoint> joints = {};
};

/// The words after the program's name, and back; false where they are not such words.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// Joints are made to stand until they confirm it or the port is gone. Port and lock are descriptors
/// `socket` + 1 and + 2. Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket, const Family& family,
          std::unique_ptr<Protocol> protocol);

}  // namespace polyarm::servo_bus
