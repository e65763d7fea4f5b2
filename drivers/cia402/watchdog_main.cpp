#include <cstdio>

#include "drivers/cia402/watchdog.hpp"
#include "drivers/watchdog/watch.hpp"

int main(int argc, char** argv) {
  using namespace polyarm;
  cia402::WatchdogSettings settings;
  if (!cia402::settings_from(argc, argv, settings)) {
    std::fprintf(stderr, "the driver cia402 starts this program to watch over its drives\n");
    return 2;
  }
  constexpr int kBusAndLock = 2;
  watchdog::become_watchdog(kBusAndLock);
  return cia402::watch(settings, watchdog::kSocket);
}
