#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/xarm/far_side.hpp"
#include "drivers/xarm/link.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct XarmArguments {
  std::string maker, robot = "ufactory/xarm_6", address = "127.0.0.1", start, firmware = "1.12.10";
  xarm::FarPorts ports;
  int cycle = 4, report_ms = 10;
  std::vector<std::string> wires, orders;
};

/// As many angles as the robot has joints.
wire::Seven xarm_start(const std::string& text, std::size_t axes) {
  wire::Seven out{};
  const auto words = split_words(text, " ,;");
  if (words.empty()) return out;
  for (std::size_t i = 0; i < axes; ++i) {
    const auto value = i < words.size() ? parse_number(words[i]) : std::nullopt;
    if (words.size() != axes || !value || !(std::abs(*value) <= 720))
      throw WrongUse("bad-value", fmt::format("'{}' is not {} angles", text, axes),
                     "degrees, for example \"0 -30 -30 0 60 0\"");
    out[i] = *value;
  }
  return out;
}

xarm::FarSideOptions xarm_options(const XarmArguments& a) {
  Problems warnings;
  xarm::FarSideOptions out;
  out.machine.facts = xarm::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  out.machine.start = xarm_start(a.start, out.machine.facts.axes);
  out.machine.firmware = a.firmware;
  out.machine.cycle_ms = a.cycle;
  out.address = a.address;
  out.ports = a.ports;
  out.real_ms = a.report_ms;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(xarm::FarSide& far) {
  far.with([&](xarm::Machine& m) {
    const xarm::Report report = m.report();
    const auto q = m.q();
    tell(fmt::format(
        "mode {}, state {}, motors {}, error {}, {} moves in the queue, joints {:.3f} degrees",
        static_cast<int>(report.mode), static_cast<int>(report.state), m.enabled() ? "on" : "off", m.error(),
        report.queued,
        fmt::join(q.begin(), q.begin() + static_cast<std::ptrdiff_t>(m.options().facts.axes), " ")));
  });
}

int simulate(const XarmArguments& a) {
  xarm::FarSide far(xarm_options(a));
  for (const std::string& text : a.wires) {
    const auto [output, input] = wire_of(text, 0, xarm::kMostSignals - 1);
    far.with(
        [&, output = output, input = input](xarm::Machine& machine) { machine.wire_output(output, input); });
  }
  for (const std::string& order : a.orders) far.order(order);
  const xarm::FarPorts ports = far.ports();
  tell(fmt::format("{} at {}: commands at port {}, reports at {} (normal), {} (rich) and {} (motion)",
                   a.robot, a.address, ports.command, ports.normal, ports.rich, ports.real));
  tell("type `state`, or a fault such as e_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_xarm(int argc, char** argv) {
  CommandLine app(
      "Simulates a controller of UFACTORY byte for byte, for drivers and programs without a robot",
      "polyarm far-side");
  XarmArguments a;
  app.add_option("maker", a.maker, "xarm")->required()->one_of({"xarm"});
  app.add_option("--robot", a.robot, "a robot of the maker with five to seven axes in the catalogue")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  const auto port = [&](const char* option, int& value, const char* what) {
    app.add_option(option, value, what)->range(0, 65535)->capture_default_str();
  };
  port("--port", a.ports.command, "commands, TCP; below 1024 it needs rights; 0: a free one");
  port("--normal-port", a.ports.normal, "normal reports, TCP; 0: a free one");
  port("--rich-port", a.ports.rich, "rich reports, TCP; 0: a free one");
  port("--report-port", a.ports.real, "reports for motion, TCP; 0: a free one");
  app.add_option("--firmware", a.firmware, "version that it names")->capture_default_str();
  app.add_option("--cycle", a.cycle, "ms, its cycle")->range(1, 20)->capture_default_str();
  app.add_option("--report-ms", a.report_ms, "ms between two reports for motion")
      ->range(1, 1000)
      ->capture_default_str();
  app.add_option("--start", a.start, "angles where the robot begins, in degrees, one for each joint");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the input follows the output; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(examples({"polyarm far-side xarm --port 5020", "polyarm far-side xarm --robot ufactory/xarm_7",
                       "polyarm far-side xarm --port 5020 --order e_stop"}) +
             "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + xarm::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  return simulate(a);
}

}  // namespace polyarm::apps
