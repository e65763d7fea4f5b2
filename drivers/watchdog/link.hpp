#pragma once
/// The driver's side of a watchdog process.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/watchdog/watch.hpp"

namespace polyarm::watchdog {

/// Finds a program beside this driver, which may be a module or linked in. Returns its path; empty if not
/// found.
std::string find_program(const char* name);

enum class Health : std::uint8_t {
  fine,
  missing,      ///< the program cannot be started
  not_ready,    ///< it has not answered
  cannot_open,  ///< it cannot open the device
  gone,         ///< it has ended
  deaf,         ///< it does not read heartbeats
  tripped       ///< it has made the device safe, because this process hung
};

/// Words for a message about a watchdog.
struct Names {
  const char* program;
  std::string device;  ///< "the motor board at /dev/i2c-1 0x60"
  std::string path;    ///< "/dev/i2c-1"
  std::string safe;    ///< "motors are off"
  std::string made;    ///< its action: "turned the motors of … off"
  int timeout_ms;
};
/// The fault and what to do; empty for `fine`.
std::string sentence(Health health, const Names& names);

/// One thread at a time. Only start() and stop() wait.
class Link {
 public:
  Link() = default;
  ~Link() { stop(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Starts the process and waits until it has opened the device. `handed`: descriptors of this process that
  /// it inherits after its socket, in that order.
  Health start(const std::string& program, std::vector<std::string> words, std::span<const int> handed = {});
  bool running() const noexcept { return socket_ >= 0; }
  /// Sets the rate to eight heartbeats per watchdog timeout, for calls to beat() every `period` s.
  void expect(int timeout_ms, double period) noexcept;

  // The following functions neither wait nor allocate.
  Health arm() noexcept;
  Health disarm() noexcept { return say(Word::disarm); }
  Health make_safe() noexcept { return say(Word::make_safe); }
  /// Call it once in each cycle.
  Health beat() noexcept;
  Health listen() noexcept;  ///< checks for messages
  /// Closes the socket. The watchdog then makes the device safe, however long that takes, and ends.
  void abandon() noexcept;
  /// Ends the watchdog and waits for its end, two seconds at most.
  void stop() noexcept;
  int process() const noexcept { return process_; }

 private:
  Health say(Word word) noexcept;
  Health wait_ready();
  int socket_ = -1, process_ = 0, unreceived_ = 0;
  std::uint64_t since_beat_ = 0, beat_every_ = 1;  // cycles
};

}  // namespace polyarm::watchdog
