#pragma once
/// The watchdog process of a controller of UFACTORY in forward mode: when the driving process hangs or has
/// died, it empties the controller's queue, and the robot stops.
#include <string>
#include <vector>

namespace polyarm::xarm {

inline constexpr const char* kWatchdogProgram = "polyarm_xarm_watchdog";

struct WatchdogSettings {
  std::string host;
  int command_port = 502;
  int timeout_ms = 2000;    ///< without a heartbeat
  int answer_ms = 1000;     ///< of the controller, until a new connection is tried
  int give_up_ms = 60'000;  ///< if the controller is not reached
};
/// The command line of the program, and back; false: the words are no settings.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);
/// Runs until the driver ends. Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket);

}  // namespace polyarm::xarm
