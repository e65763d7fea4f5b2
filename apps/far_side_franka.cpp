#include <fmt/format.h>

#include <cmath>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/franka/far_side.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct FrankaArguments {
  std::string maker, robot = "franka/fr3", address = "127.0.0.1", start;
  int port = franka::kRobotPort, hand_port = franka::kHandPort, version = 0;
  std::vector<std::string> orders;
};

/// Seven angles in degrees.
wire::Seven franka_start(const std::string& text, wire::Seven otherwise) {
  const auto words = split_words(text, " ,;");
  if (words.empty()) return otherwise;
  wire::Seven out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto value = i < words.size() ? parse_number(words[i]) : std::nullopt;
    if (words.size() != out.size() || !value || !(std::abs(*value) <= 360))
      throw WrongUse("bad-value", fmt::format("'{}' is not seven angles", text),
                     "degrees, for example \"0 -45 0 -135 0 90 45\"");
    out[i] = *value * 0.017453292519943295;
  }
  return out;
}

franka::FarSideOptions franka_options(const FrankaArguments& a) {
  Problems warnings;
  franka::FarSideOptions out;
  out.machine.facts = franka::facts_of(description::load_robot(a.robot, open_catalogue(), warnings));
  if (a.version != 0) out.machine.facts.version = a.version;
  out.machine.start = franka_start(a.start, out.machine.start);
  out.address = a.address;
  out.port = a.port;
  out.hand_port = a.hand_port;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show(franka::FarSide& far) {
  far.with([&](franka::Machine& m) {
    const auto q = m.q();
    const std::string errors = franka::error_names(m.errors());
    tell(fmt::format("mode {}, errors: {}, joints {:.3f} degrees, {} commands", franka::name(m.mode()),
                     errors.empty() ? "none" : errors, fmt::join(q, " "), m.commands()));
  });
}

int simulate(const FrankaArguments& a) {
  franka::FarSide far(franka_options(a));
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} at {}: robot at port {}, hand at port {}, interface version {}", a.robot, a.address,
                   far.port(), far.hand_port(), far.with([](franka::Machine& m) { return m.version(); })));
  tell("type `state`, or a fault such as user_stop; Ctrl-C ends it");
  serve_far_side([&] { show(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace

int run_far_side_franka(int argc, char** argv) {
  CommandLine app("Simulates a robot of Franka byte for byte, for drivers and programs without a robot",
                  "polyarm far-side");
  FrankaArguments a;
  app.add_option("maker", a.maker, "franka")->required()->one_of({"franka"});
  app.add_option("--robot", a.robot, "franka/fr3 or franka/fer_panda, or another one with seven axes")
      ->capture_default_str();
  app.add_option("--address", a.address, "address to listen at; 0.0.0.0: every network of this machine")
      ->capture_default_str();
  app.add_option("--port", a.port, "the robot's TCP port; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--hand-port", a.hand_port, "that of its hand; 0: a free one")
      ->range(0, 65535)
      ->capture_default_str();
  app.add_option("--interface", a.version,
                 "version of the Franka Control Interface; 0: 5 for a Panda, else 9")
      ->range(0, 10);
  app.add_option("--start", a.start, "seven angles where the robot begins, in degrees");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(examples({"polyarm far-side franka", "polyarm far-side franka --robot franka/fer_panda",
                       "polyarm far-side franka --order user_stop"}) +
             "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + franka::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  if (a.version != 0 && a.version < franka::kOldestVersion)
    throw WrongUse("bad-value", fmt::format("there is no interface version {} here", a.version), "5 to 10");
  return simulate(a);
}

}  // namespace polyarm::apps
