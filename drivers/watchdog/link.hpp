#pragma once
/// The driver's end of a watchdog.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/watchdog/watch.hpp"

namespace polyarm::watchdog {

/// Where a program lies: beside this driver, as a module or linked in. Empty: nowhere.
std::string find_program(const char* name);

enum class Health : std::uint8_t {
  fine,
  missing,      ///< the program cannot be started
  not_ready,    ///< it has not answered
  cannot_open,  ///< it cannot open the device
  gone,         ///< it has ended
  deaf,         ///< it takes no heartbeats
  tripped       ///< it has made the device safe, since this process stood still
};

/// What a sentence about a watchdog needs.
struct Names {
  const char* program;
  std::string device;  ///< "the motor board at /dev/i2c-1 0x60"
  std::string path;    ///< "/dev/i2c-1"
  std::string safe;    ///< "motors are off"
  std::string made;    ///< what it does: "turned the motors of … off"
  int timeout_ms;
};
/// What is wrong and what to do; empty for `fine`.
std::string sentence(Health health, const Names& names);

/// One thread at a time. Only start() and stop() wait.
class Link {
 public:
  Link() = default;
  ~Link() { stop(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Starts the process and waits until it holds the device. `handed`: descriptors of this process that it
  /// finds behind its socket, in that order.
  Health start(const std::string& program, std::vector<std::string> words, std::span<const int> handed = {});
  bool running() const noexcept { return socket_ >= 0; }
  /// Eight heartbeats in the watchdog's time, of calls to beat() that come once in `period` s.
  void expect(int timeout_ms, double period) noexcept;

  // The following neither wait nor allocate.
  Health arm() noexcept;
  Health disarm() noexcept { return say(Word::disarm); }
  Health make_safe() noexcept { return say(Word::make_safe); }
  /// Once in each cycle.
  Health beat() noexcept;
  Health listen() noexcept;  ///< has it said something?
  /// Closes the socket: the watchdog makes the device safe, for as long as that takes, and ends.
  void abandon() noexcept;
  /// Tells it to end and waits until it has, two seconds at most.
  void stop() noexcept;
  int process() const noexcept { return process_; }

 private:
  Health say(Word word) noexcept;
  Health wait_ready();
  int socket_ = -1, process_ = 0, unheard_ = 0;
  std::uint64_t since_beat_ = 0, beat_every_ = 1;  // cycles
};

}  // namespace polyarm::watchdog
