#pragma once
/// The watchdog process: makes a device safe when the driving process hangs or has died. A handler inside the
/// driving process is not enough, because SIGKILL and SIGSTOP leave it no time. The watchdog has only the
/// device and one end of a socket; the driver defines how to make the device safe.
#include <charconv>
#include <cstring>
#include <functional>

namespace polyarm::watchdog {

/// Messages on the socket (SOCK_SEQPACKET), one byte each; `ready` is followed by the process id.
enum class Word : char {
  arm = 'A',        ///< heartbeats are expected from now on
  beat = 'B',       ///< one heartbeat
  disarm = 'D',     ///< the driver has made the device safe or takes care of it; heartbeats end
  make_safe = 'S',  ///< the driver cannot make it safe: the watchdog does, until it is done or the driver
                    ///< sends another word
  quit = 'Q',       ///< ends the process
  ready = 'R',      ///< to the driver: the device is open
  no_device = 'N',  ///< to the driver: the device cannot be opened
  tripped = 'T',    ///< to the driver: heartbeats were missing, and the device is being made safe
};

/// The result of an attempt to make the device safe.
enum class Attempt {
  done,     ///< confirmed
  again,    ///< try again
  hopeless  ///< the device no longer exists
};

/// The functions that make a device safe. Each call is one attempt and may wait for the device.
struct MakingSafe {
  std::function<Attempt()> stop;
  /// After a trip, once the device is stopped: closes the device to commands that the driver still had
  /// pending. False: stop it once more and try again. May be empty.
  std::function<bool()> shut = {};
  /// At an end requested by the driver; false makes the process end with a failure. May be empty.
  std::function<bool()> leave = {};
};

struct Patience {
  int timeout_ms = 0;       ///< without a heartbeat
  int give_up_ms = 60'000;  ///< if the device does not become safe and the driver has ended
};

/// The number of the watchdog's socket descriptor. Other inherited descriptors follow.
constexpr int kSocket = 3;

/// Leaves the session of the driver (whose Ctrl-C would reach it too) and closes all inherited descriptors
/// except the socket and the `handed` ones after it. Returns only in a child; the calling process ends.
void become_watchdog(int handed = 0);

/// Runs until `quit`, or until the other end of the socket is closed, by any death of the driver: then it
/// makes the device safe, repeatedly until the device confirms. If heartbeats end while it is armed, it first
/// notifies the driver (so that a driver that continues at this moment does not move anything), then makes
/// the device safe and shuts it. Returns the exit code of the process.
int watch(int socket, const Patience& patience, const MakingSafe& safe);

/// Notifies the driver that the device cannot be opened. Returns the exit code of the process.
int watch_nothing(int socket);

/// Parses a word of the command line as an integer; false if it is invalid or out of range.
template <typename Number>
bool read_number(const char* text, Number& out) {
  const char* end = text + std::strlen(text);
  const auto result = std::from_chars(text, end, out);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace polyarm::watchdog
