#pragma once
/// The process that makes a device safe when the one that drives it stands still or is gone. No handler
/// within the driving process is enough: SIGKILL and SIGSTOP leave it no moment. This process has the device
/// and one end of a socket, nothing else; how the device is made safe is the driver's to say.
#include <charconv>
#include <cstring>
#include <functional>

namespace polyarm::watchdog {

/// Messages on the socket (SOCK_SEQPACKET), one byte each; `ready` is followed by the process id.
enum class Word : char {
  arm = 'A',        ///< from now on heartbeats are expected
  beat = 'B',       ///<
  disarm = 'D',     ///< the driver has made the device safe itself or sees to it; heartbeats end
  make_safe = 'S',  ///< the driver cannot: until it is done, or the driver says another thing
  quit = 'Q',       ///< end
  ready = 'R',      ///< to the driver: the device is open
  no_device = 'N',  ///< to the driver: it is not
  tripped = 'T',    ///< to the driver: heartbeats were missing, and the device is being made safe
};

/// What came of an attempt to make the device safe.
enum class Attempt {
  done,     ///< it has confirmed that it is
  again,    ///< not yet
  hopeless  ///< it is no longer there
};

/// How a device is made safe. Each function is one attempt and may wait for the device.
struct MakingSafe {
  std::function<Attempt()> stop;
  /// After a trip, once stopped: shut the device against what the driver had still in hand when it was
  /// stopped. False: stop it once more and try again. May be empty.
  std::function<bool()> shut = {};
  /// At the end that the driver asks for; false makes the process end with a failure. May be empty.
  std::function<bool()> leave = {};
};

struct Patience {
  int timeout_ms = 0;       ///< without a heartbeat
  int give_up_ms = 60'000;  ///< with a device that does not become safe, once the driver is gone
};

/// The descriptor at which the watchdog finds its socket. What else is handed to it follows.
constexpr int kSocket = 3;

/// Leaves the session of the driver (whose Ctrl-C would reach it too) and closes what it has inherited beyond
/// the socket and the `handed` descriptors behind it. Comes back in a child alone; the process that was
/// called ends.
void become_watchdog(int handed = 0);

/// Until it is told to quit, or the other end of the socket is closed, by whatever death: then the device is
/// made safe, again and again until it confirms. When heartbeats end while it is armed, the driver is told
/// first (so that, when it goes on just now, it does not drive on), then the device is made safe and shut.
/// Returns the exit code of the process.
int watch(int socket, const Patience& patience, const MakingSafe& safe);

/// Tells the driver that the device cannot be opened. Returns the exit code of the process.
int watch_nothing(int socket);

/// A word of the command line as a whole number; false where it is none or out of range.
template <typename Number>
bool read_number(const char* text, Number& out) {
  const char* end = text + std::strlen(text);
  const auto result = std::from_chars(text, end, out);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace polyarm::watchdog
