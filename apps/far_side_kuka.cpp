#include <fmt/format.h>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/kuka/far_side.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct KukaArguments {
  std::string maker, robot = "kuka/kr_10_r1100_3", address = "127.0.0.1", start, rsi = "127.0.0.1:59152",
                     sen_type = kuka::kSenType;
  int port = 54600, cycle = 4, late_limit = 25;
  double limit = 360;
  bool relative = false, running = false;
  std::vector<std::string> wires, orders;
};

kuka::FarSideOptions kuka_options(const KukaArguments& a) {
  Problems warnings;
  kuka::FarSideOptions out;
  out.machine.facts = kuka::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  out.machine.start = start_of(a.start, out.machine.start);
  kuka::EkiIdentity& identity = out.machine.identity;
  identity.cycle_ms = a.cycle;
  identity.late_limit = a.late_limit;
  identity.correction_limit = a.limit;
  identity.relative = a.relative;
  out.address = a.address;
  out.eki = a.port;
  const std::size_t colon = a.rsi.rfind(':');
  const auto port = colon == std::string::npos ? std::nullopt : parse_number(a.rsi.substr(colon + 1));
  if (!port || *port < 1 || *port > 65535)
    throw WrongUse("bad-value", "'" + a.rsi + "' is not HOST:PORT", "for example 127.0.0.1:59152");
  out.rsi_host = a.rsi.substr(0, colon);
  out.rsi = static_cast<int>(*port);
  out.sen_type = a.sen_type;
  out.running = a.running;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(kuka::FarSide& far) {
  constexpr const char* kModes[] = {"", "T1", "T2", "AUT", "EXT"};
  far.with([&](kuka::Machine& m) {
    const kuka::EkiState s = m.reply().state;
    tell(fmt::format("{}, drives {}{}{}{}, RSI {}, joints {:.3f} degrees",
                     kModes[static_cast<std::size_t>(s.mode)], s.drives ? "on" : "off",
                     s.emergency_stop ? ", emergency stop" : "", s.guard_stop ? ", guard open" : "",
                     s.message ? ", a message" : "", s.rsi ? "runs" : "is off", fmt::join(m.q(), " ")));
  });
}

int simulate(const KukaArguments& a) {
  kuka::FarSide far(kuka_options(a));
  for (const std::string& text : a.wires) {
    const auto [output, input] = wire_of(text, 1, static_cast<int>(kuka::kMostSignals));
    far.with(
        [&, output = output, input = input](kuka::Machine& machine) { machine.wire_output(output, input); });
  }
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} at {}: EthernetKRL at port {}, RSI every {} ms to {}", a.robot, a.address,
                   far.eki_port(), a.cycle, a.rsi));
  tell("type `state`, or a fault such as e_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_kuka(int argc, char** argv) {
  CommandLine app("Simulates a controller of KUKA byte for byte, for drivers and programs without a robot",
                  "polyarm far-side");
  KukaArguments a;
  app.add_option("maker", a.maker, "kuka")->required()->one_of({"kuka"});
  app.add_option("--robot", a.robot, "a robot of the maker with six axes in the catalogue")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--port", a.port, "EthernetKRL, TCP; 0: a free one")->range(0, 65535)->capture_default_str();
  app.add_option("--rsi", a.rsi, "HOST:PORT of the driver, as PolyarmRsi.xml has it")->capture_default_str();
  app.add_option("--sen-type", a.sen_type, "SENTYPE of its configuration of RSI")->capture_default_str();
  app.add_option("--cycle", a.cycle, "ms, the cycle of RSI: 4 or 12")->range(4, 12)->capture_default_str();
  app.add_option("--late-limit", a.late_limit, "late answers in a row, until RSI ends")
      ->range(1, 1000)
      ->capture_default_str();
  app.add_option("--limit", a.limit, "degrees of each axis away from where RSI began")
      ->range(0.1, 720.0)
      ->capture_default_str();
  app.add_flag("--relative", a.relative, "RSI takes relative corrections");
  app.add_flag("--running", a.running, "RSI runs from the beginning, for a driver without EthernetKRL");
  app.add_option("--start", a.start, "six angles where the robot begins, in degrees");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the input follows the output; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(examples({"polyarm far-side kuka", "polyarm far-side kuka --cycle 12 --wire 1=1",
                       "polyarm far-side kuka --order busy"}) +
             "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + kuka::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  if (a.cycle != 4 && a.cycle != 12)
    throw WrongUse("bad-value", "RSI has a cycle of 4 or of 12 ms", "write --cycle 4 or --cycle 12");
  return simulate(a);
}

}  // namespace polyarm::apps
