#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/franka/setup.hpp"

namespace polyarm::apps {

int run_setup_franka(int argc, char** argv) {
  CommandLine app(
      "Looks at a robot of Franka (Research 3, Panda), and says what to set in Desk; nothing moves",
      "polyarm setup");
  franka::SetupOptions o;
  std::string device;
  app.add_option("device", device, "franka")->required()->one_of({"franka"});
  app.add_option("--host", o.host, "address of the robot's controller, as Desk has it")->required();
  app.add_option("--port", o.port, "TCP port of the Franka Control Interface")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_flag("--hand", o.hand, "looks for the Franka Hand too");
  app.add_option("--hand-port", o.hand_port, "TCP port of the hand")->range(1, 65535)->capture_default_str();
  app.footer(
      examples({"polyarm setup franka --host 172.16.0.2", "polyarm setup franka --host 172.16.0.2 --hand"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  o.say = [](const std::string& text) { tell(text); };
  return franka::set_up(o) ? kOk : kFailed;
}

}  // namespace polyarm::apps
