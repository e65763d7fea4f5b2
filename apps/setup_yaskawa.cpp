#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/yaskawa/setup.hpp"

namespace polyarm::apps {

int run_setup_yaskawa(int argc, char** argv) {
  CommandLine app(
      "Looks at a controller of Yaskawa, its Ethernet server and MotoROS, and says what to set at its "
      "pendant; "
      "nothing moves",
      "polyarm setup");
  yaskawa::SetupOptions o;
  std::string device, motion = "stream";
  app.add_option("device", device, "yaskawa")->required()->one_of({"yaskawa"});
  app.add_option("--host", o.host, "address of the controller; without it 192.168.255.1");
  app.add_option("--port", o.motion_port, "TCP port of MotoROS for motion")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--state-port", o.state_port, "TCP port of MotoROS for states")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--io-port", o.io_port, "TCP port of MotoROS for signals")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--hses-port", o.hses_port, "UDP port of the Ethernet server")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--group", o.group, "control group of the robot")->range(0, 3)->capture_default_str();
  app.add_option("--motion", motion,
                 "stream: points to MotoROS; forward: moves over the Ethernet server alone")
      ->one_of({"stream", "forward"})
      ->capture_default_str();
  app.add_option("--write", o.folder,
                 "a folder for our job INIT_ROS.JBI; of forward mode: POLYARM.JBI and LADDER.TXT");
  app.footer(examples({"polyarm setup yaskawa --host 192.168.255.1",
                       "polyarm setup yaskawa --host 192.168.255.1 --write yaskawa_files",
                       "polyarm setup yaskawa --host 192.168.255.1 --motion forward --write yaskawa_files"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  o.forward = motion == "forward";
  o.say = [](const std::string& text) { tell(text); };
  return yaskawa::set_up(o) ? kOk : kFailed;
}

}  // namespace polyarm::apps
