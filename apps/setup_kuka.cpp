#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/kuka/setup.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::apps {

int run_setup_kuka(int argc, char** argv) {
  CommandLine app(
      "Looks at a controller of KUKA and writes the programs and configurations that the driver needs; "
      "nothing moves",
      "polyarm setup");
  kuka::SetupOptions o;
  o.krl.own_address.clear();
  std::string device;
  app.add_option("device", device, "kuka")->required()->one_of({"kuka"});
  app.add_option("--host", o.host,
                 "address of the controller (KLI); without it the one that KUKA delivers, 172.31.1.147");
  app.add_option("--rsi-host", o.rsi_host, "address of the controller in its network for RSI");
  app.add_option("--own", o.krl.own_address,
                 "address of this computer for RSI; without it the one that reaches the controller");
  app.add_option("--port", o.krl.eki_port, "TCP port of EthernetKRL")->range(1, 65535)->capture_default_str();
  app.add_option("--rsi-port", o.krl.rsi_port, "UDP port of this computer for RSI")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--rsi", o.krl.rsi, "version of RSI: 3, 4 or 5")->range(3, 5)->capture_default_str();
  app.add_option("--cycle", o.krl.cycle_ms, "ms, the cycle of RSI: 4 or 12")
      ->range(4, 12)
      ->capture_default_str();
  app.add_option("--late-limit", o.krl.late_limit, "late answers in a row, until RSI ends")
      ->range(1, 1000)
      ->capture_default_str();
  app.add_option("--limit", o.krl.correction, "degrees that RSI may move an axis away from where it began")
      ->range(0.1, 720.0)
      ->capture_default_str();
  app.add_flag("--relative", o.krl.relative, "relative corrections instead of absolute ones");
  app.add_option("--write", o.folder, "a folder for the programs and configurations");
  app.footer(examples({"polyarm setup kuka --host 172.31.1.147 --write kuka_files",
                       "polyarm setup kuka --host 172.31.1.147 --rsi-host 192.168.1.147 --rsi 4"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (o.krl.cycle_ms != 4 && o.krl.cycle_ms != 12)
    throw WrongUse("bad-value", "RSI has a cycle of 4 or of 12 ms", "write --cycle 4 or --cycle 12");
  o.say = [](const std::string& text) { tell(text); };
  return kuka::set_up(o) ? kOk : kFailed;
}

}  // namespace polyarm::apps
