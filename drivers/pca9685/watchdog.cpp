#include "drivers/pca9685/watchdog.hpp"

#include <chrono>
#include <memory>
#include <thread>

#include "drivers/pca9685/chip.hpp"
#include "drivers/watchdog/watch.hpp"

namespace polyarm::drivers {

using watchdog::Attempt;
using watchdog::read_number;

std::vector<std::string> words_of(const WatchdogSettings& s) {
  return {s.bus, std::to_string(s.address), std::to_string(s.timeout_ms), std::to_string(s.pulse_us),
          std::to_string(s.give_up_ms)};
}

bool settings_from(int argc, char** argv, WatchdogSettings& s) {
  if (argc != 6) return false;
  s.bus = argv[1];
  return !s.bus.empty() && read_number(argv[2], s.address) && read_number(argv[3], s.timeout_ms) &&
         read_number(argv[4], s.pulse_us) && read_number(argv[5], s.give_up_ms) && s.timeout_ms > 0 &&
         s.pulse_us > 0;
}

int watch(const WatchdogSettings& settings, int socket, const BusOpener& open) {
  BusFailure failure;
  const std::unique_ptr<I2cBus> bus = open(settings.bus, settings.address, failure);
  if (!bus) return watchdog::watch_nothing(socket);
  Pca9685 chip(*bus);
  watchdog::MakingSafe safe;
  safe.stop = [&] { return chip.off() ? Attempt::again : Attempt::done; };
  safe.shut = [&] {
    std::this_thread::sleep_for(std::chrono::microseconds(settings.pulse_us) + std::chrono::milliseconds(1));
    return !chip.sleep();
  };
  safe.leave = [&] { return !chip.off(); };
  return watchdog::watch(socket, {settings.timeout_ms, settings.give_up_ms}, safe);
}

}  // namespace polyarm::drivers
