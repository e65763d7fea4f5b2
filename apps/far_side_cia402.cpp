#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "drivers/cia402/far_side.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct Cia402Arguments {
  std::string maker, link, start;
  int drives = 6;
  double counts_per_turn = 4096, gear = 100;
  std::vector<std::string> orders;
};

/// Angles in degrees, one for each drive.
std::vector<double> cia402_start(const Cia402Arguments& a) {
  const auto words = split_words(a.start, " ,;");
  std::vector<double> out(static_cast<std::size_t>(a.drives));
  if (words.empty()) return out;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto value = i < words.size() ? parse_number(words[i]) : std::nullopt;
    if (words.size() != out.size() || !value || !(std::abs(*value) <= 3600))
      throw WrongUse("bad-value", fmt::format("'{}' is not {} angles", a.start, a.drives),
                     "degrees, one for each drive");
    out[i] = *value * std::numbers::pi / 180;
  }
  return out;
}

cia402::FarSideOptions cia402_options(const Cia402Arguments& a) {
  cia402::FarSideOptions out;
  const std::vector<double> start = cia402_start(a);
  for (int k = 0; k < a.drives; ++k) {
    cia402::FarDriveOptions drive;
    drive.node = k + 1;
    drive.counts_per_rad = a.counts_per_turn * a.gear / (2 * std::numbers::pi);
    drive.start = start[static_cast<std::size_t>(k)];
    out.machine.drives.push_back(drive);
  }
  out.link = a.link;
  out.report = [](const std::string& text) { tell(text); };
  return out;
}

void show_drives(cia402::FarSide& far) {
  far.with([](cia402::Machine& machine) {
    for (cia402::FarDrive& drive : machine.drives())
      tell(fmt::format("node {}: {}{}, {} counts, {:.3f} degrees", drive.node(), drive.state_name(),
                       drive.operational() ? "" : ", not operational", drive.position(),
                       drive.angle() * 180 / std::numbers::pi));
  });
}

}  // namespace

int run_far_side_cia402(int argc, char** argv) {
  CommandLine app(
      "Simulates servo drives with CiA 402 behind a CAN adapter with SLCAN, byte for byte, for drivers and "
      "programs without drives",
      "polyarm far-side");
  Cia402Arguments a;
  app.add_option("maker", a.maker, "cia402")->required()->one_of({"cia402"});
  app.add_option("--drives", a.drives, "how many; their nodes are 1, 2, …")
      ->range(1, 12)
      ->capture_default_str();
  app.add_option("--link", a.link, "a path that becomes a link to the serial port, such as /tmp/can");
  app.add_option("--counts-per-turn", a.counts_per_turn, "of each motor")
      ->range(1.0, 1e9)
      ->capture_default_str();
  app.add_option("--gear", a.gear, "turns of each motor for one of its joint")
      ->range(1e-3, 1e5)
      ->capture_default_str();
  app.add_option("--start", a.start, "angles where the joints begin, in degrees, one for each drive");
  app.add_option("--order", a.orders, "a fault from the beginning; may be repeated");
  app.footer(
      examples({"polyarm far-side cia402 --link /tmp/can", "polyarm far-side cia402 --drives 3 --gear 50",
                "polyarm far-side cia402 --order torque_off=2"}) +
      "\nFaults, typed or with --order, as KIND or KIND=NUMBER:\n" + cia402::FarSide::kinds());
  if (const auto code = app.parse(argc, argv)) return *code;
  cia402::FarSide far(cia402_options(a));
  for (const std::string& order : a.orders) far.order(order);
  tell(fmt::format("{} drives behind the serial port {}", a.drives, far.path()));
  tell("type `state`, or a fault such as over_current=2; Ctrl-C ends it");
  serve_far_side([&] { show_drives(far); }, [&](const std::string& line) { far.order(line); });
  return kOk;
}

}  // namespace polyarm::apps
