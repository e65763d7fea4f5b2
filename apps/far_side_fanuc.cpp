#include <fmt/format.h>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/fanuc/far_side.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct FanucArguments {
  std::string maker, robot = "fanuc/crx_10ia_l", address = "127.0.0.1", start;
  int stream = 60015, rmi = 16001, session = 16002, sampling = 8, version = 3;
  std::vector<std::string> wires, orders;
};

fanuc::FarSideOptions fanuc_options(const FanucArguments& a) {
  Problems warnings;
  fanuc::FarSideOptions out;
  out.machine.facts = fanuc::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  out.machine.start = start_of(a.start, out.machine.start);
  out.address = a.address;
  out.stream = a.stream, out.rmi = a.rmi, out.session = a.session;
  out.sampling_ms = a.sampling;
  out.version = static_cast<std::uint32_t>(a.version);
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(fanuc::FarSide& far) {
  constexpr const char* kModes[] = {"AUTO", "T1", "T2"};
  const bool runs = far.program_runs();
  far.with([&](fanuc::Machine& m) {
    tell(fmt::format("{}, {}, STREAM_MOTN {}, joints {:.3f} degrees",
                     kModes[static_cast<std::size_t>(m.mode())],
                     m.alarm_text().empty() ? "no alarm" : m.alarm_text(), runs ? "runs" : "does not run",
                     fmt::join(m.q(), " ")));
  });
}

int simulate(const FanucArguments& a) {
  fanuc::FarSide far(fanuc_options(a));
  for (const std::string& text : a.wires) {
    const auto [output, input] = wire_of(text, 1, fanuc::Machine::kPorts);
    far.with([&](fanuc::Machine& machine) { machine.wire_output(output, input); });
  }
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} at {}: Stream Motion {} (version {}, {} ms), Remote Motion {}", a.robot, a.address,
                   far.stream_port(), a.version, a.sampling, far.rmi_port()));
  tell("type `state`, or a fault such as e_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_fanuc(int argc, char** argv) {
  CommandLine app("Simulates a controller of FANUC byte for byte, for drivers and programs without a robot",
                  "polyarm far-side");
  FanucArguments a;
  app.add_option("maker", a.maker, "fanuc")->required()->one_of({"fanuc"});
  app.add_option("--robot", a.robot, "a robot of the maker with six axes in the catalogue")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--port", a.stream, "Stream Motion, UDP; 0 on any port: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--rmi-port", a.rmi, "Remote Motion Interface, TCP")->range(0, 65535)->capture_default_str();
  app.add_option("--session-port", a.session, "its sessions")->range(0, 65535)->capture_default_str();
  app.add_option("--sampling", a.sampling, "ms, the cycle of Stream Motion")
      ->range(1, 20)
      ->capture_default_str();
  app.add_option("--protocol", a.version, "version of Stream Motion")->range(3, 4)->capture_default_str();
  app.add_option("--start", a.start, "six angles where the robot begins, in degrees");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the digital input follows the output; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(
      examples({"polyarm far-side fanuc", "polyarm far-side fanuc --robot fanuc/lr_mate_200id --wire 1=1",
                "polyarm far-side fanuc --order busy"}) +
      "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + fanuc::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  return simulate(a);
}

}  // namespace polyarm::apps
