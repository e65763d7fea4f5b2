#include <fmt/format.h>

#include <cmath>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/abb/far_side.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct AbbArguments {
  std::string maker, robot = "abb/irb_120", address = "127.0.0.1", start, egm = "127.0.0.1:6510";
  std::string user = "Default User", password = "robotics";
  std::string motion = "stream";
  int rws = 2, port = -1, sampling = 4, moves_port = abb::kMovesPort;
  double max_speed = 60;
  std::vector<std::string> signals, wires, orders;
};

abb::FarSideOptions abb_options(const AbbArguments& a) {
  Problems warnings;
  abb::FarSideOptions out;
  out.machine.facts = abb::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  out.machine.start = start_of(a.start, out.machine.start);
  out.machine.rapid.sampling_ms = a.sampling;
  out.machine.rapid.max_speed = a.max_speed;
  if (a.rws == 1) out.machine.software = "6.16.02.00";
  for (const std::string& name : a.signals) out.machine.signals[name] = false;
  out.address = a.address;
  out.rws_version = a.rws;
  out.rws = a.port >= 0 ? a.port : a.rws == 1 ? 8080 : 8443;
  out.user = a.user, out.password = a.password;
  const bool forward = a.motion == "forward";
  out.moves = forward ? a.moves_port : 0;
  if (forward) out.machine.modules = {abb::kMovesModule};
  const std::size_t colon = a.egm.rfind(':');
  const auto port = colon == std::string::npos ? std::nullopt : parse_number(a.egm.substr(colon + 1));
  if (!port || *port < 1 || *port > 65535)
    throw WrongUse("bad-value", "'" + a.egm + "' is not HOST:PORT", "for example 127.0.0.1:6510");
  out.egm_host = a.egm.substr(0, colon);
  out.egm = static_cast<int>(*port);
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(abb::FarSide& far) {
  far.with([&](abb::Machine& m) {
    tell(fmt::format("{}, {}, the program {}, joints {:.3f} degrees", m.mode_text(), m.control(),
                     m.program_runs() ? "runs" : "does not run", fmt::join(m.q(), " ")));
  });
}

int simulate(const AbbArguments& a) {
  abb::FarSide far(abb_options(a));
  for (const std::string& text : a.wires) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      throw WrongUse("bad-value", "'" + text + "' is not OUTPUT=INPUT",
                     "names of signals, for example doA=diA");
    far.with([&](abb::Machine& machine) {
      machine.wire_output(text.substr(0, equals), text.substr(equals + 1));
      machine.set_input(text.substr(0, equals), false);
    });
  }
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} at {}: Robot Web Services {} at port {}, EGM every {} ms to {}", a.robot, a.address,
                   a.rws, far.rws_port(), a.sampling, a.egm));
  if (a.motion == "forward")
    tell(fmt::format("the program PolyarmMoves listens at port {}", far.moves_port()));
  tell("type `state`, or a fault such as e_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_abb(int argc, char** argv) {
  CommandLine app("Simulates a controller of ABB byte for byte, for drivers and programs without a robot",
                  "polyarm far-side");
  AbbArguments a;
  app.add_option("maker", a.maker, "abb")->required()->one_of({"abb"});
  app.add_option("--robot", a.robot, "a robot of the maker with six axes in the catalogue")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--rws", a.rws, "Robot Web Services: 1 (IRC5) or 2 (OmniCore)")
      ->range(1, 2)
      ->capture_default_str();
  app.add_option("--port", a.port, "Robot Web Services, TCP; without it 8080 (1) or 8443 (2); 0: a free one")
      ->range(0, 65535);
  app.add_option("--egm", a.egm, "HOST:PORT of the driver, as a UDPUC device has it")->capture_default_str();
  app.add_option("--sampling", a.sampling, "ms, the sample rate of EGM")->range(4, 48)->capture_default_str();
  app.add_option("--max-speed", a.max_speed, "degrees/s, MaxSpeedDeviation of EGM")
      ->range(0.1, 1000.0)
      ->capture_default_str();
  app.add_option("--motion", a.motion, "stream: it has the module PolyarmEGM; forward: PolyarmMoves")
      ->one_of({"stream", "forward"})
      ->capture_default_str();
  app.add_option("--moves-port", a.moves_port, "of PolyarmMoves, TCP; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--user", a.user, "of Robot Web Services")->capture_default_str();
  app.add_option("--start", a.start, "six angles where the robot begins, in degrees");
  app.add_option("--signal", a.signals, "a digital signal; may be repeated");
  app.add_option("--wire", a.wires, "OUTPUT=INPUT: the signal follows the other one; may be repeated");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(examples({"polyarm far-side abb", "polyarm far-side abb --rws 1 --wire doVacuum=diHolds",
                       "polyarm far-side abb --motion forward --wire doVacuum=diHolds",
                       "polyarm far-side abb --order mastership"}) +
             "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + abb::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  return simulate(a);
}

}  // namespace polyarm::apps
