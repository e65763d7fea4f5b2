#pragma once
/// The action of the watchdog process (see drivers/watchdog) for a CAN bus: a quick stop of every drive. It
/// is needed for drives that do not watch the heartbeat of this computer.
#include <string>
#include <vector>

#include "drivers/cia402/can_bus.hpp"

namespace polyarm::cia402 {

inline constexpr const char* kWatchdogProgram = "polyarm_cia402_watchdog";

struct WatchdogSettings {
  std::string bus = {};  ///< it is open already; its name says what kind it is
  int answer_ms = 0, timeout_ms = 0, give_up_ms = 60'000;
  std::vector<int> nodes = {};
};
/// Converts the settings to words of a command line and back; false for wrong words.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// One attempt: orders a quick stop by SDO, and asks each drive until it no longer moves its motor. True when
/// all have confirmed it.
bool stop_all(CanBus& bus, const std::vector<int>& nodes, Nanoseconds answer, BusState& state);

/// Stops the drives until they confirm it or the adapter is gone. Bus and lock are the descriptors `socket` +
/// 1 and + 2. Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket);

}  // namespace polyarm::cia402
