/// Two processes for the tests: the watchdog as it is, with the fake bus in the place of Linux's; and with
/// the word `drive` a driver of two wheels that does as it is told on standard input.
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "drivers/pca9685/watchdog.hpp"
#include "polyarm/base/error.hpp"
#include "tests/pca9685/rig.hpp"

namespace polyarm::test {
namespace {

using hardware::CallbackReturn;
using hardware::ReturnType;

int tell(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
  return 1;
}

bool start(hardware::Component& component) {
  if (component.on_configure() == CallbackReturn::success &&
      component.on_activate() == CallbackReturn::success)
    return tell("driving") != 0;
  tell("refused: " + component.reason());
  return false;
}

/// A line, if there is one within a period of the loop; the pace of the loop is the wait.
std::string heard() {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  if (poll(&waiting, 1, 20) <= 0) return {};
  char buffer[64];
  const ssize_t n = ::read(STDIN_FILENO, buffer, sizeof buffer - 1);
  if (n <= 0) std::_Exit(9);  // the test is gone
  return {buffer, static_cast<std::size_t>(n)};
}

int drive(const std::string& bus) {
  drivers::Pca9685Component component(fake_environment());
  auto parameters = jetbot(bus);
  parameters["watchdog_ms"] = "1000";
  component.on_init(wheels_on(parameters));
  if (!start(component)) return 1;
  const double commands[] = {0.5, 0.5};
  double states[4];
  bool failed = false;
  for (hardware::Cycle cycle{0, 20'000'000, 0};; ++cycle.index) {
    const std::string word = heard();
    if (word == "return\n") return 0;
    if (word == "exit\n") std::exit(0);  // without the destructor
    if (word == "abort\n") std::abort();
    if (word == "throw\n") throw std::runtime_error("nobody catches this");
    if (word == "crash\n") *static_cast<volatile int*>(nullptr) = 1;
    if (word == "spin\n")
      for (volatile bool for_ever = true; for_ever;) {
      }
    if (word == "activate\n") {
      component.on_error();
      failed = !start(component);
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
