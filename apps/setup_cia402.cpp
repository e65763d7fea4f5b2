#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/cia402/setup.hpp"

namespace polyarm::apps {

int run_setup_cia402(int argc, char** argv) {
  CommandLine app("Lists the drives on a CAN bus: what they are, their state and position; it reads only",
                  "polyarm setup");
  cia402::SetupOptions o;
  std::string device;
  app.add_option("device", device, "cia402")->required()->one_of({"cia402"});
  app.add_option("--bus", o.bus.bus, "CAN interface (can0), or the serial port of an adapter with SLCAN")
      ->required();
  app.add_option("--bit-rate", o.bus.bit_rate, "bit/s of the CAN bus; that of can0 is set by `ip link`")
      ->range(10000, 1000000)
      ->capture_default_str();
  app.add_option("--baud", o.bus.baud, "bit/s of the serial port")->capture_default_str();
  app.add_option("--first", o.first, "first node that is asked")->range(1, 127)->capture_default_str();
  app.add_option("--last", o.last, "last node that is asked")->range(1, 127)->capture_default_str();
  app.footer(
      examples({"polyarm setup cia402 --bus can0", "polyarm setup cia402 --bus /dev/ttyACM0 --last 6"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  o.bus.holder = "polyarm setup";
  o.say = [](const std::string& text) { tell(text); };
  return cia402::set_up(o) ? kOk : kFailed;
}

}  // namespace polyarm::apps
