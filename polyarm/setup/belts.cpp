#include "polyarm/setup/belts.hpp"

#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {
constexpr std::size_t kMostBelts = 64;

BeltEntry read_belt(const std::string& name, const Yaml& y, Problems& problems) {
  y.check_keys({"at", "xyz", "rpy", "quaternion", "turns", "encoder", "scale", "wraps", "sensor", "latch",
                "sensor_at", "from", "start_by", "to", "lead"},
               problems);
  BeltEntry out;
  out.name = name;
  out.where = y.where();
  out.frame.turns = y["turns"].boolean(false);
  out.frame.at_zero = y.pose();
  out.encoder = y.required("encoder").text();
  const Dimension way = out.frame.turns ? Dimension::angle : Dimension::length;
  out.scale = y["scale"].number(way, 1);
  out.wraps = y["wraps"].number(Dimension::none, 0);
  out.sensor = y["sensor"].text("");
  out.latch = y["latch"].text("");
  out.sensor_at = y["sensor_at"].number(way, 0);
  out.from = y.required("from").number(way);
  out.to = y.required("to").number(way);
  out.start_by = y["start_by"].number(way, out.to);
  out.lead = y["lead"].number(Dimension::time, 0);
  if (!(std::isfinite(out.scale) && out.scale != 0))
    problems.error("bad-value", y["scale"].where(), "the scale of the encoder is zero",
                   "write the way for one count, such as scale: 0.05mm");
  if (!(out.wraps >= 0))
    problems.error("bad-value", y["wraps"].where(), "an encoder cannot begin again after fewer than 0 counts",
                   "write such as wraps: 65536, or leave it out");
  if (!(out.from < out.start_by && out.start_by <= out.to))
    problems.error("bad-value", y.where(),
                   "the belt '" + name +
                       "' needs from < start_by <= to: where robots begin to follow, until where "
                       "they may begin, and where they must have ended",
                   "parts travel from smaller to larger places, along x");
  constexpr double kMostLead = 0.2;  // s
  if (!(out.lead >= 0 && out.lead <= kMostLead))
    problems.error("bad-value", y["lead"].where(), "lead is " + y["lead"].text(), "between 0s and 200ms");
  if (out.sensor.empty() && !out.latch.empty())
    problems.error("bad-value", y["latch"].where(), "the belt '" + name + "' has a latch, but no sensor",
                   "add sensor: what counts the parts");
  return out;
}
}  // namespace

std::vector<BeltEntry> read_belts(const Yaml& yaml, Problems& problems) {
  std::vector<BeltEntry> out;
  if (!yaml.defined()) return out;
  if (!yaml.is_map()) {
    problems.error(
        "bad-type", yaml.where(), "'belts' has no names of belts",
        "write 'belts: {line: {at: [0.5, 0, 0], encoder: scene/belt/position, from: 0.1, to: 0.6}}'");
    return out;
  }
  if (yaml.keys().size() > kMostBelts) {
    problems.error("too-many", yaml.where(),
                   "the cell has more than " + std::to_string(kMostBelts) + " belts",
                   "divide it into several cells");
    return out;
  }
  for (const std::string& name : yaml.keys()) {
    if (name == "world" || name == "base" || name.find('/') != std::string::npos) {
      problems.error("bad-name", yaml[name].where(),
                     "a belt cannot be called '" + name + "': it names a frame", "choose another name");
      continue;
    }
    collect(problems, [&] { out.push_back(read_belt(name, yaml[name], problems)); });
  }
  return out;
}

}  // namespace polyarm::cell
