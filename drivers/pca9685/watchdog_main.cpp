#include <cstdio>

#include "drivers/pca9685/watchdog.hpp"
#include "drivers/watchdog/watch.hpp"

int main(int argc, char** argv) {
  using namespace polyarm::drivers;
  WatchdogSettings settings;
  if (!settings_from(argc, argv, settings)) {
    std::fprintf(stderr, "the driver pca9685 starts this program to watch over a motor board\n");
    return 2;
  }
  polyarm::watchdog::become_watchdog();
  return watch(settings, polyarm::watchdog::kSocket,
               [](const std::string& path, std::uint8_t address, BusFailure& failure) {
                 return open_linux_bus(path, address, failure);
               });
}
