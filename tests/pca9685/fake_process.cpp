/// Two processes for the tests: the watchdog as it is, with the fake bus in the place of Linux's; and with
/// the word `drive` a driver of two wheels that does as it is told on standard input.
#include <string>

#include "drivers/pca9685/watchdog.hpp"
#include "polyarm/base/error.hpp"
#include "tests/pca9685/rig.hpp"
#include "tests/support/told_driver.hpp"

namespace polyarm::test {
namespace {

using hardware::ReturnType;

int drive(const std::string& bus) {
  drivers::Pca9685Component component(fake_environment());
  auto parameters = jetbot(bus);
  parameters["watchdog_ms"] = "1000";
  component.on_init(wheels_on(parameters));
  if (!start(component, "driving")) return 1;
  const double commands[] = {0.5, 0.5};
  double states[4];
  bool failed = false;
  for (hardware::Cycle cycle{0, 20'000'000, 0};; ++cycle.index) {
    const std::string word = heard(20);
    if (is_to_return(word)) return 0;
    if (word == "activate") {
      component.on_error();
      failed = !start(component, "driving");
    }
    const bool fine =
        component.write(cycle, commands) == ReturnType::ok && component.read(cycle, states) == ReturnType::ok;
    if (!fine && !failed) tell("error: " + component.reason());
    failed = !fine;
  }
}
}  // namespace
}  // namespace polyarm::test

int main(int argc, char** argv) {
  using namespace polyarm;
  if (argc == 3 && std::string(argv[1]) == "drive") return test::drive(argv[2]);
  drivers::WatchdogSettings settings;
  if (!drivers::settings_from(argc, argv, settings)) return 2;
  settings.give_up_ms = 20'000;  // a board of a test that has ended never answers
  watchdog::become_watchdog();
  return drivers::watch(settings, watchdog::kSocket, test::open_fake_bus);
}
