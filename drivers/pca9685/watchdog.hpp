#pragma once
/// What the watchdog (drivers/watchdog) does to a board. The chip keeps its last duty for ever.
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
  int pulse_us = 0;         ///< one pulse period of the chip: that long it takes until outputs are off
  int give_up_ms = 60'000;  ///< with a bus that does not answer, once the driver is gone
};

/// The words after the program's name, and back; false where they are not such words.
std::vector<std::string> words_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// Motors off, until the chip has answered; after a standstill of the driver the chip is sent to sleep as
/// well, so that a duty that the driver still had in hand when it was stopped moves nothing when it goes on.
/// Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket, const BusOpener& open);

}  // namespace polyarm::drivers
