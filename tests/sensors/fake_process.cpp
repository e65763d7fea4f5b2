/// A sensor that is read by a process of its own: NAME PORT STATE; tells that state when it is asked.
#include <memory>
#include <string>
#include <vector>

#include "drivers/sensors/serial_imu.hpp"
#include "drivers/sensors/ublox_gnss.hpp"
#include "tests/support/told_driver.hpp"

namespace polyarm::test {
namespace {

int measure(hardware::Component& component, const std::string& port, const std::string& state) {
  hardware::ComponentContext context;
  context.name = "unit";
  // On a machine that is busy with other work, seconds may pass between two messages.
  context.parameters = {{"port", port}, {"timeout", "60"}, {"start_timeout", "60"}};
  hardware::RobotInstance robot;
  robot.name = "cart";
  context.robots = {robot};
  component.on_init(context);
  if (!start(component, "measuring")) return 1;
  const auto interfaces = component.state_interfaces();
  std::vector<double> states(interfaces.size());
  for (hardware::Cycle cycle{0, 10'000'000, 0};; ++cycle.index) {
    const bool wanted = !heard(10).empty();
    if (component.read(cycle, states) != hardware::ReturnType::ok) tell("error: " + component.reason());
    for (std::size_t k = 0; wanted && k < states.size(); ++k)
      if (interfaces[k].name.ends_with("/" + state)) tell(std::to_string(states[k]));
  }
}
}  // namespace
}  // namespace polyarm::test

int main(int argc, char** argv) {
  using namespace polyarm;
  if (argc != 4) return 2;
  std::unique_ptr<hardware::Component> component;
  if (std::string(argv[1]) == "serial_imu")
    component = std::make_unique<sensors::SerialImu>();
  else
    component = std::make_unique<sensors::UbloxGnss>();
  return test::measure(*component, argv[2], argv[3]);
}
