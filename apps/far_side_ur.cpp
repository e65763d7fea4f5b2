#include <fmt/format.h>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/ur/far_side.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct UrArguments {
  std::string maker, robot = "universal_robots/ur5e", address = "127.0.0.1", software = "5.15";
  int port = 30004, dashboard = 29999, primary = 30001, secondary = 30002;
  double rate = 0;
  bool off = false, local = false, calibrated = false;
  std::vector<std::string> wires, orders;
};

ur::FarSideOptions ur_options(const UrArguments& a) {
  Problems warnings;
  ur::FarSideOptions out;
  out.machine.facts = ur::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  if (a.calibrated) ur::make_calibrated(out.machine.facts);
  const auto parts = split_fields(a.software, '.');
  const auto number = [&](std::size_t i) {
    return i < parts.size() ? static_cast<int>(parse_number(parts[i]).value_or(-1)) : 0;
  };
  out.machine.major = number(0), out.machine.minor = number(1), out.machine.bugfix = number(2);
  if (out.machine.major < 1 || out.machine.major > 255 || out.machine.minor < 0 || out.machine.minor > 255 ||
      out.machine.bugfix < 0)
    throw WrongUse("bad-value", "'" + a.software + "' is not a version", "for example 5.15 or 3.15.4");
  out.machine.on = !a.off;
  out.machine.remote = !a.local;
  out.address = a.address;
  out.rtde = a.port, out.dashboard = a.dashboard, out.primary = a.primary, out.secondary = a.secondary;
  out.rate = a.rate > 0 ? a.rate : out.machine.major >= 5 ? 500 : 125;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(ur::FarSide& far) {
  far.with([](ur::Machine& m) {
    tell(fmt::format("{}, {}, {} control, q {:.4f}", ur::robot_mode_name(m.robot_mode()),
                     ur::safety_mode_name(m.safety_mode()), m.remote() ? "remote" : "local",
                     fmt::join(m.q(), " ")));
  });
}

int simulate(const UrArguments& a) {
  ur::FarSide far(ur_options(a));
  for (const std::string& text : a.wires) {
    const auto [output, input] = wire_of(text, 0, 17);
    far.with([&](ur::Machine& machine) { machine.wire_output(output, input); });
  }
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} with software {} at {}: RTDE {}, dashboard {}, primary {}, secondary {}", a.robot,
                   a.software, a.address, far.rtde_port(), far.dashboard_port(), far.primary_port(),
                   far.secondary_port()));
  tell("type `state`, or a fault such as protective_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_ur(int argc, char** argv) {
  CommandLine app(
      "Simulates the controller of a robot of Universal Robots byte for byte, for drivers and programs "
      "without a robot",
      "polyarm far-side");
  UrArguments a;
  app.add_option("maker", a.maker, "ur: Universal Robots")->required()->one_of({"ur"});
  app.add_option("--robot", a.robot, "a robot of the maker in the catalogue")->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--port", a.port, "RTDE; 0 on any port: a free one")->range(0, 65535)->capture_default_str();
  app.add_option("--dashboard-port", a.dashboard, "dashboard server")->range(0, 65535)->capture_default_str();
  app.add_option("--primary-port", a.primary, "primary interface")->range(0, 65535)->capture_default_str();
  app.add_option("--secondary-port", a.secondary, "secondary interface")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--software", a.software, "version of the controller's software")->capture_default_str();
  app.add_option("--rate", a.rate, "Hz; else 500, before software 5 125")->range(10.0, 500.0);
  app.add_flag("--off", a.off, "the robot is switched off at the beginning");
  app.add_flag("--local", a.local, "local control at the beginning");
  app.add_flag("--calibrated", a.calibrated, "the arm differs from its type as real ones do");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the digital input follows the output; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(examples({"polyarm far-side ur", "polyarm far-side ur --robot universal_robots/ur3e --wire 0=0",
                       "polyarm far-side ur --order wrong_version"}) +
             "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + ur::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  return simulate(a);
}

}  // namespace polyarm::apps
