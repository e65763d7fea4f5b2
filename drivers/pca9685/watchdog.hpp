#pragma once
/// The process that turns motors off when the one that drives them stands still or is gone. The chip keeps
/// its last duty for ever, so that no handler within the driving process is enough: SIGKILL and SIGSTOP leave
/// it no moment. This process has the bus and one end of a socket, nothing else.
#include <cstdint>
#include <string>

#include "drivers/pca9685/i2c_bus.hpp"

namespace polyarm::drivers {

/// Messages on the socket (SOCK_SEQPACKET), one byte each; `ready` is followed by the process id.
enum class WatchdogWord : char {
  arm = 'A',      ///< from now on heartbeats are expected
  beat = 'B',     ///<
  disarm = 'D',   ///< motors are off, heartbeats end
  quit = 'Q',     ///< motors off once more, then end
  ready = 'R',    ///< to the driver: the bus is open
  no_bus = 'N',   ///< to the driver: it is not
  tripped = 'T',  ///< to the driver: motors were turned off, and the chip sent to sleep
};

struct WatchdogSettings {
  std::string bus = {};
  std::uint8_t address = 0;
  int timeout_ms = 0;       ///< without a heartbeat
  int pulse_us = 0;         ///< one pulse period of the chip: that long it takes until outputs are off
  int give_up_ms = 60'000;  ///< with a bus that does not answer, once the driver is gone
};

/// The words after the program's name, and back; false where they are not such words.
std::string text_of(const WatchdogSettings& settings);
bool settings_from(int argc, char** argv, WatchdogSettings& settings);

/// The descriptor at which the watchdog finds its socket.
constexpr int kWatchdogSocket = 3;

/// Leaves the session of the driver (whose Ctrl-C would reach it too) and closes what it has inherited.
/// Comes back in a child alone; the process that was called ends.
void become_watchdog();

/// Until it is told to quit, or the other end of the socket is closed, by whatever death: then motors are
/// turned off, again and again until the chip has answered. When heartbeats end while it is armed, motors are
/// turned off and the chip is sent to sleep, so that a duty that the driver still had in hand when it was
/// stopped moves nothing when it goes on. Returns the exit code of the process.
int watch(const WatchdogSettings& settings, int socket, const BusOpener& open);

}  // namespace polyarm::drivers
