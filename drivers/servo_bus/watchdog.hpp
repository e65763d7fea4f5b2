#pragma once
/// The watchdog's action for a servo bus (see drivers/watchdog). It is needed because most servos keep their
/// last speed indefinitely.
#include <string>
#include <vector>

#include "drivers/servo_bus/standstill.hpp"

namespace polyarm::servo_bus {

inline constexpr const char* kServoWatchdog = "polyarm_servo_watchdog";

struct WatchdogSettings {
  std::string family = {}, port = {};  ///< the port is already open; the name is only for process lists
  int baud = 0, answer_ms = 0;
  int timeout_ms = 0;  ///< without a heartbeat
  int give_up_ms = 60'000;
  std::vector<StandingJoint> joints = {};
};

/// Converts the settings to command-line words and back; false for invalid words.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// Stops the joints until they confirm it or the port is lost. Port and lock are descriptors `socket` + 1 and
/// + 2. Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket, const Family& family,
          std::unique_ptr<Protocol> protocol);

}  // namespace polyarm::servo_bus
