#include <cstdio>

#include "drivers/watchdog/watch.hpp"
#include "drivers/xarm/watchdog.hpp"

int main(int argc, char** argv) {
  polyarm::xarm::WatchdogSettings settings;
  if (!polyarm::xarm::settings_from(argc, argv, settings)) {
    std::fprintf(stderr, "the driver xarm starts this program to watch over a controller\n");
    return 2;
  }
  polyarm::watchdog::become_watchdog();
  return polyarm::xarm::watch(settings, polyarm::watchdog::kSocket);
}
