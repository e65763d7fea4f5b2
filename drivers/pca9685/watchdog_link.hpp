#pragma once
/// The driver's end of the watchdog.
#include <string>

#include "drivers/pca9685/watchdog.hpp"

namespace polyarm::drivers {

/// Where the program lies: beside this driver, as a module or linked in. Empty: nowhere.
std::string find_watchdog();

class WatchdogLink {
 public:
  enum class Health : std::uint8_t {
    fine,
    missing,      ///< the program cannot be started
    not_ready,    ///< it has not answered
    cannot_open,  ///< it cannot open the bus
    gone,         ///< it has ended
    deaf,         ///< it takes no heartbeats
    tripped       ///< it has turned motors off, since this process stood still
  };

  WatchdogLink() = default;
  ~WatchdogLink() { stop(); }
  WatchdogLink(const WatchdogLink&) = delete;
  WatchdogLink& operator=(const WatchdogLink&) = delete;

  /// Starts the process and waits until it holds the bus.
  Health start(const std::string& program, const WatchdogSettings& settings);
  // The following neither wait nor allocate.
  Health arm() noexcept { return say(WatchdogWord::arm); }
  Health disarm() noexcept { return say(WatchdogWord::disarm); }
  Health beat() noexcept;
  Health listen() noexcept;  ///< has it said something?
  /// Closes the socket: the watchdog turns motors off, for as long as that takes, and ends.
  void abandon() noexcept;
  /// Tells it to end and waits until it has, two seconds at most.
  void stop() noexcept;
  int process() const noexcept { return process_; }

 private:
  Health say(WatchdogWord word) noexcept;
  Health wait_ready();
  int socket_ = -1, process_ = 0, unheard_ = 0;
};

}  // namespace polyarm::drivers
