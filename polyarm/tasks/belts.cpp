#include "polyarm/tasks/belts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

void TravelFilter::add(double travel, Nanoseconds time) {
  constexpr double kMemory = 120;  // 1/s
  if (samples_ == 0 || time <= value_.time) {
    if (samples_ > 0) return;
    value_ = {travel, 0, 0, time};
    samples_ = 1;
    return;
  }
  const double dt = seconds(time - value_.time);
  // At first the memory is as long as there are samples: a line, then a parabola, through all of them.
  samples_ = std::min(samples_ + 1, 1000);
  const double n = samples_;
  const double fade = std::exp(-kMemory * dt),
               keep = std::min(fade, samples_ < 1000 ? (n - 1) / (n + 1) : 1.0);
  const double g = 1 - keep * keep * keep, h = 1.5 * (1 - keep * keep) * (1 - keep),
               k = 0.5 * (1 - keep) * (1 - keep) * (1 - keep);
  value_ = value_.after(dt);
  value_.time = time;
  const double error = travel - value_.travel;
  value_.travel += g * error;
  value_.velocity += h / dt * error;
  value_.acceleration += samples_ > 20 ? 2 * k / (dt * dt) * error : 0;
}

Belts::Belts(const std::vector<BeltEntry>& entries, const Machine& machine, const data::DataStore& store)
    : machine_(machine), store_(store) {
  for (const BeltEntry& entry : entries) {
    Belt belt;
    belt.entry = entry;
    belt.encoder = signal_of(entry.encoder, "encoder", entry);
    if (!entry.sensor.empty()) belt.sensor = signal_of(entry.sensor, "sensor", entry);
    if (!entry.latch.empty()) belt.latch = signal_of(entry.latch, "latch", entry);
    if (store.find(entry.name))
      throw Error(Problem{"bad-name", entry.where,
                          "the belt '" + entry.name + "' is called like a name of the data",
                          "choose another name for one of them"});
    belts_[entry.name] = std::move(belt);
  }
}

Belts::Signal Belts::signal_of(const std::string& name, const char* what, const BeltEntry& entry) const {
  if (const auto state = machine_.table().find_state(name)) return {*state, {}};
  if (store_.find(name)) return {{}, name};
  std::vector<std::string> known = machine_.table().state_names();
  for (const std::string& tag : store_.names()) known.push_back(tag);
  throw Error(Problem{
      "unknown-signal", entry.where,
      fmt::format("the {} of the belt '{}' is '{}', which is no state of the hardware and no tag{}", what,
                  entry.name, name, did_you_mean(name, known)),
      fmt::format("write such as scene/belt/position; or add the tag, `{}: {{initial: 0}}`, below `tags:` "
                  "of signals.yaml, or to a link",
                  name)});
}

std::optional<double> Belts::read(const Signal& signal) const {
  double out = NAN;
  if (signal.state) {
    const std::vector<double>& states = machine_.snapshot().states;
    if (*signal.state < states.size()) out = states[*signal.state];
  } else if (const data::Value* value = store_.find(signal.tag)) {
    if (const data::Number* number = value->as_number()) out = number->value;
    if (const bool* truth = value->as_boolean()) out = *truth ? 1 : 0;
  }
  return std::isfinite(out) ? std::optional(out) : std::nullopt;
}

void Belts::tick() {
  const Nanoseconds time = machine_.snapshot().cycle.time;
  for (auto& [name, belt] : belts_) {
    const std::optional<double> counts = read(belt.encoder);
    belt.silent = !counts;
    if (!counts) continue;
    if (belt.entry.wraps > 0 && belt.counts)
      belt.turns -= belt.entry.wraps * std::round((*counts - *belt.counts) / belt.entry.wraps);
    belt.counts = *counts;
    belt.filter.add(belt.entry.scale * (*counts + belt.turns), time);
    look_at_sensor(belt);
  }
}

/// The counts of the encoder without its steps back; `counts` is from the last half turn.
double Belts::unwrapped(const Belt& belt, double counts) const {
  if (!(belt.entry.wraps > 0)) return counts;
  return counts + belt.turns - belt.entry.wraps * std::round((counts - *belt.counts) / belt.entry.wraps);
}

/// A sensor that is true or false sees one part each time it becomes true.
void Belts::look_at_sensor(Belt& belt) {
  if (belt.entry.sensor.empty()) return;
  const std::optional<double> seen = read(belt.sensor);
  if (!seen) return;
  const double before = belt.seen.value_or(*seen);
  belt.seen = *seen;
  if (*seen <= before) return;
  // Of parts that were counted in one tick only the newest has a known place.
  belt.missed +=
      static_cast<std::size_t>(std::clamp(*seen - before - 1, 0.0, static_cast<double>(kMostWaiting)));
  const std::optional<double> latched = belt.entry.latch.empty() ? std::nullopt : read(belt.latch);
  const BeltEntry& entry = belt.entry;
  const double travel = latched ? entry.scale * unwrapped(belt, *latched) : belt.filter.value().travel;
  queue(belt,
        entry.frame.turns ? Pose{{}, from_axis_angle({0, 0, 1}, entry.sensor_at)}
                          : Pose{{entry.sensor_at, 0, 0}, {}},
        travel);
}

void Belts::queue(Belt& belt, const Pose& at, double travel) {
  belt.parts.push_back({++belt.numbers, at, travel});
  if (belt.parts.size() <= kMostWaiting) return;
  belt.parts.pop_front();
  ++belt.missed;
}

Belts::Belt& Belts::known(const std::string& name) {
  const auto at = belts_.find(name);
  if (at == belts_.end()) {
    std::vector<std::string> names;
    for (const auto& each : belts_) names.push_back(each.first);
    throw Error("unknown-belt", "the cell has no belt '" + name + "'" + did_you_mean(name, names),
                names.empty() ? "describe it in cell.yaml: belts" : "known are: " + join(names, ", "));
  }
  if (at->second.silent && machine_.snapshot().cycle.time > 0)
    throw Error("signal", "the encoder of the belt '" + name + "' gives no numbers", "look at its hardware");
  return at->second;
}

double Belts::place(const std::string& name, const BeltPart& part) const {
  const Belt& belt = belts_.at(name);
  const double gone = belt.filter.value().travel - part.travel;
  if (!belt.entry.frame.turns) return part.at.position.x + gone;
  const bool beside = std::hypot(part.at.position.x, part.at.position.y) > 0;
  return gone + (beside ? std::atan2(part.at.position.y, part.at.position.x) : to_rpy(part.at.rotation).z);
}

Pose Belts::pose(const std::string& name, const BeltPart& part, double travel) const {
  const BeltEntry& entry = belts_.at(name).entry;
  return entry.frame.at(travel - part.travel) * part.at;
}

bool Belts::next_part(const std::string& name, const std::string& robot) {
  Belt& belt = known(name);
  while (!belt.parts.empty()) {
    const BeltPart part = belt.parts.front();
    belt.parts.pop_front();
    if (place(name, part) > belt.entry.start_by) {
      ++belt.missed;
      continue;
    }
    belt.taken[robot] = part;
    return true;
  }
  return false;
}

std::size_t Belts::waiting(const std::string& name) {
  const Belt& belt = known(name);
  return static_cast<std::size_t>(
      std::count_if(belt.parts.begin(), belt.parts.end(),
                    [&](const BeltPart& part) { return place(name, part) <= belt.entry.start_by; }));
}

std::size_t Belts::missed(const std::string& name) {
  const Belt& belt = known(name);
  return belt.missed + belt.parts.size() - waiting(name);
}

void Belts::add(const std::string& name, const Pose& at) {
  Belt& belt = known(name);
  queue(belt, at, belt.filter.value().travel);
}

void Belts::note_missed(const std::string& name, std::uint64_t part) {
  Belt& belt = belts_.at(name);
  for (auto& [robot, taken] : belt.taken)
    if (taken.number == part && std::exchange(taken.missed, true)) return;
  ++belt.missed;
}

const BeltPart& Belts::part(const std::string& name, const std::string& robot) const {
  const auto& taken = belts_.at(name).taken;
  const auto at = taken.find(robot);
  if (at == taken.end())
    throw Error("no-part", "'" + robot + "' has no part on the belt '" + name + "' yet",
                "write `wait next_part(\"" + name + "\")` before its moves in this frame");
  return at->second;
}

void Belts::suppose_part(const std::string& name, const std::string& robot) {
  Belt& belt = known(name);
  const double from = belt.entry.from;
  belt.taken[robot] = {
      0, belt.entry.frame.turns ? Pose{{}, from_axis_angle({0, 0, 1}, from)} : Pose{{from, 0, 0}, {}},
      belt.filter.value().travel};
}

void Belts::forget_supposed() {
  for (auto& [name, belt] : belts_)
    std::erase_if(belt.taken, [](const auto& part) { return part.second.number == 0; });
}

}  // namespace polyarm::cell
