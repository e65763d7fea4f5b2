#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/xarm/setup.hpp"

namespace polyarm::apps {

int run_setup_xarm(int argc, char** argv) {
  CommandLine app(
      "Looks at a controller of UFACTORY (xArm, Lite 6, 850), and says what to set in UFACTORY Studio; "
      "nothing "
      "moves",
      "polyarm setup");
  xarm::SetupOptions o;
  std::string device;
  app.add_option("device", device, "xarm")->required()->one_of({"xarm"});
  app.add_option("--host", o.host, "address of the controller, as the label on the control box has it")
      ->required();
  app.add_option("--port", o.command_port, "TCP port for commands")->range(1, 65535)->capture_default_str();
  app.add_option("--rich-port", o.rich_port, "TCP port for rich reports")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--report-port", o.real_port, "TCP port for reports for motion")
      ->range(1, 65535)
      ->capture_default_str();
  app.footer(examples({"polyarm setup xarm --host 192.168.1.200"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  o.say = [](const std::string& text) { tell(text); };
  return xarm::set_up(o) ? kOk : kFailed;
}

}  // namespace polyarm::apps
