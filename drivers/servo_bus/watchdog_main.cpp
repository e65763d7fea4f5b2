#include <cstdio>
#include <memory>

#include "drivers/dynamixel/family.hpp"
#include "drivers/dynamixel/protocol2.hpp"
#include "drivers/feetech/family.hpp"
#include "drivers/feetech/protocol0.hpp"
#include "drivers/servo_bus/watchdog.hpp"
#include "drivers/watchdog/watch.hpp"

int main(int argc, char** argv) {
  using namespace polyarm;
  servo_bus::WatchdogSettings settings;
  const bool words = servo_bus::settings_from(argc, argv, settings);
  if (!words || (settings.family != "feetech" && settings.family != "dynamixel")) {
    std::fprintf(stderr, "the drivers feetech and dynamixel start this program to watch over their joints\n");
    return 2;
  }
  constexpr int kPortAndLock = 2;
  watchdog::become_watchdog(kPortAndLock);
  if (settings.family == "feetech")
    return servo_bus::watch(settings, watchdog::kSocket, feetech::sts_family(),
                            std::make_unique<feetech::Protocol0>());
  return servo_bus::watch(settings, watchdog::kSocket, dynamixel::x_family(),
                          std::make_unique<dynamixel::Protocol2>());
}
