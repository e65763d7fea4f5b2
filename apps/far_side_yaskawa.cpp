#include <fmt/format.h>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/yaskawa/far_side.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/description/tools.hpp"

namespace polyarm::apps {

namespace {

struct YaskawaArguments {
  std::string maker, robot = "yaskawa/gp7", address = "127.0.0.1", start, tool, bytes = "little";
  int motion = yaskawa::kMotionPort, state = yaskawa::kStatePort, io = yaskawa::kIoPort,
      hses = yaskawa::kHsesPort, cycle = 4, state_ms = 25, group = 0;
  std::vector<std::string> wires, orders;
};

yaskawa::FarSideOptions yaskawa_options(const YaskawaArguments& a) {
  Problems warnings;
  yaskawa::FarSideOptions out;
  out.machine.facts = yaskawa::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  out.machine.start = start_of(a.start, out.machine.start);
  out.machine.interpolation_ms = a.cycle;
  out.machine.group = a.group;
  out.tool = description::find_tool(a.tool, ".").tcp;
  out.address = a.address;
  out.motion = a.motion;
  out.state = a.state;
  out.io = a.io;
  out.hses = a.hses;
  out.order = a.bytes == "big" ? wire::ByteOrder::big : wire::ByteOrder::little;
  out.state_ms = a.state_ms;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(yaskawa::FarSide& far) {
  far.with([&](yaskawa::Machine& m) {
    const yaskawa::HsesStatus s = m.panel();
    tell(fmt::format("{}{}, servos {}{}{}{}, job {} {}, {} steps in the buffer, joints {:.3f} degrees",
                     s.teach ? "teach" : "play", s.remote ? " with remote" : "", s.servo ? "on" : "off",
                     s.holds() ? ", hold" : "", s.error ? ", an error" : "",
                     s.alarm ? fmt::format(", alarm {}", m.alarm().code) : "", m.job(),
                     m.ready()   ? "waits for MotoROS"
                     : s.running ? "runs"
                                 : "stands",
                     m.queued(), fmt::join(m.q(), " ")));
  });
}

int simulate(const YaskawaArguments& a) {
  yaskawa::FarSide far(yaskawa_options(a));
  for (const std::string& text : a.wires) {
    const auto [output, input] = wire_of(text, 1, yaskawa::kMostSignals);
    far.with([&, output = output, input = input](yaskawa::Machine& machine) {
      machine.wire_output(output, input);
    });
  }
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format(
      "{} at {}: MotoROS with motion at port {}, states at {}, signals at {}; Ethernet server at {}", a.robot,
      a.address, far.motion_port(), far.state_port(), far.io_port(), far.hses_port()));
  tell("type `state`, or a fault such as e_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_yaskawa(int argc, char** argv) {
  CommandLine app("Simulates a controller of Yaskawa byte for byte, for drivers and programs without a robot",
                  "polyarm far-side");
  YaskawaArguments a;
  app.add_option("maker", a.maker, "yaskawa")->required()->one_of({"yaskawa"});
  app.add_option("--robot", a.robot, "a robot of the maker with six axes in the catalogue")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--port", a.motion, "motion of MotoROS, TCP; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--state-port", a.state, "states of MotoROS, TCP; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--io-port", a.io, "signals of MotoROS, TCP; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--hses-port", a.hses, "the Ethernet server, UDP; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--bytes", a.bytes, "byte order of MotoROS: little or big")
      ->one_of({"little", "big"})
      ->capture_default_str();
  app.add_option("--cycle", a.cycle, "ms, the interpolation cycle")->range(1, 20)->capture_default_str();
  app.add_option("--state-ms", a.state_ms, "ms between two states")->range(1, 1000)->capture_default_str();
  app.add_option("--group", a.group, "control group of the robot")->range(0, 3)->capture_default_str();
  app.add_option("--start", a.start, "six angles where the robot begins, in degrees");
  app.add_option("--tool", a.tool, "the tool whose TCP its tool file has, as in a cell; for forward mode");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the input follows the output; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(
      examples({"polyarm far-side yaskawa", "polyarm far-side yaskawa --bytes big --wire 1=1",
                "polyarm far-side yaskawa --tool suction_cup", "polyarm far-side yaskawa --order teach"}) +
      "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + yaskawa::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  return simulate(a);
}

}  // namespace polyarm::apps
