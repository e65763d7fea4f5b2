#pragma once
/// The watchdog's action for a motor board (see drivers/watchdog). It is needed because the chip keeps its
/// last duty indefinitely.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/pca9685/i2c_bus.hpp"

namespace polyarm::drivers {

inline constexpr const char* kPca9685Watchdog = "polyarm_pca9685_watchdog";

struct WatchdogSettings {
  std::string bus = {};
  std::uint8_t address = 0;
  int timeout_ms = 0;       ///< without a heartbeat
  int pulse_us = 0;         ///< one pulse period of the chip, after which the outputs are off
  int give_up_ms = 60'000;  ///< if the bus does not answer and the driver has ended
};

/// Converts the settings to command-line words and back; false for invalid words.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// Turns motors off until the chip has confirmed it. After a hang of the driver it also puts the chip to
/// sleep, so that a duty that the driver still had pending cannot move anything. Returns the exit code of the
/// process.
int watch(const WatchdogSettings& settings, int socket, const BusOpener& open);

}  // namespace polyarm::drivers
