/// Requests about interfaces, the loop and its limits.
#include <cmath>

#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

double rate_of(const Machine& machine, const hardware::HostedInfo& info) {
  return info.period > 0 ? 1 / seconds(info.period) : 1 / seconds(machine.period()) / info.divisor;
}
double rate_of(const Machine& machine, const control::ListedController& controller) {
  return controller.period > 0 ? 1 / seconds(controller.period)
                               : 1 / seconds(machine.period()) / controller.divisor;
}

namespace {

using namespace protocol;

/// The parts of the cell that requests about the loop read.
struct HealthOwners {
  const Machine& machine;
  const LifeCycle& life;
  const Watches& watches;
};

OrNull<double> number_or_null(double value) {
  OrNull<double> out;
  if (std::isfinite(value)) out = value;
  return out;
}

InterfacesList::Answer interfaces_list(const HealthOwners& cell, const InterfacesList&) {
  const hardware::InterfaceTable& table = cell.machine.table();
  const control::Snapshot& seen = cell.machine.snapshot();
  InterfacesList::Answer out;
  for (std::size_t i = 0; i < table.state_names().size(); ++i)
    if (!table.state_names()[i].empty())
      out.states.push_back({table.state_names()[i], number_or_null(seen.states[i])});
  for (std::size_t i = 0; i < table.command_names().size(); ++i) {
    const std::string& name = table.command_names()[i];
    if (!name.empty())
      out.commands.push_back(
          {name, number_or_null(seen.commands[i]), cell.machine.controllers().holder_of(name)});
  }
  return out;
}

Times times(const realtime::Histogram& values) {
  return {values.percentile(0.5), values.percentile(0.99), values.max()};
}

/// The same, with the distribution of the samples.
Distribution distribution(const realtime::Histogram& values) {
  Distribution out{values.percentile(0.5), values.percentile(0.99), values.max(), {}};
  values.quarters([&](Nanoseconds to, std::uint64_t count) { out.buckets.push_back({to, count}); });
  return out;
}

PartThread thread_of(double rate, bool own_clock, const realtime::ThreadHealth& thread) {
  return {.component = {},
          .controller = {},
          .rate_hz = rate,
          .own_clock = own_clock,
          .runs = thread.runs,
          .late = thread.late,
          .missed = thread.missed,
          .cost = times(thread.cost),
          .wake_up = times(thread.wake_up),
          .period = times(thread.period)};
}

LoopPart part_of(double rate, const realtime::PartHealth& part) {
  return {{}, {}, rate, part.cost.count(), times(part.cost), times(part.period)};
}

void add_components(const HealthOwners& cell, protocol::LoopHealth::Answer& out) {
  hardware::Hardware& hardware = cell.machine.hardware();
  const control::Snapshot& seen = cell.machine.snapshot();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const std::string& name = hardware.component_name(i);
    if (i < seen.fallen.size() && seen.fallen[i] != control::StopCause::none)
      out.fallen.push_back({name, control::name(seen.fallen[i]), control::code(seen.fallen[i]),
                            cell.machine.stopped_with(name)});
    const hardware::Diagnostics& diagnostics = hardware.diagnostics();
    const hardware::HostedInfo info = diagnostics.info(i);
    const double rate = rate_of(cell.machine, info);
    if (const realtime::ThreadHealth* thread = diagnostics.thread_health(i))
      out.threads.emplace_back(thread_of(rate, info.period > 0, *thread)).component = name;
    else if (diagnostics.part_health(i).cost.count() > 0)
      out.parts.emplace_back(part_of(rate, diagnostics.part_health(i))).component = name;
  }
}

void add_controllers(const HealthOwners& cell, protocol::LoopHealth::Answer& out) {
  for (const control::ListedController& c : cell.machine.controllers().list())
    if (c.thread)
      out.threads.emplace_back(thread_of(rate_of(cell.machine, c), false, *c.thread)).controller = c.name;
    else if (c.part->cost.count() > 0)
      out.parts.emplace_back(part_of(rate_of(cell.machine, c), *c.part)).controller = c.name;
}

protocol::LoopHealth::Answer health(const HealthOwners& cell, const protocol::LoopHealth&) {
  const control::Health& h = cell.machine.health();
  const control::Snapshot& seen = cell.machine.snapshot();
  protocol::LoopHealth::Answer out;
  out.state = control::name(seen.state);
  out.cause = cell.life.stop_cause().what;
  out.cause_code = cell.life.stop_cause().code;
  out.standing = seen.standing;
  out.override_percent = 100 * cell.machine.supervisor().override_share();
  out.allowed_percent = 100 * cell.machine.supervisor().share();
  if (!cell.watches.stops().empty()) out.last_stop.emplace(facts_of(cell.watches.stops().back()));
  out.time_s = seconds(seen.cycle.time);
  out.rate_hz = 1 / seconds(cell.machine.period());
  out.cycles = h.cycles;
  out.late = h.late;
  out.cost = distribution(h.cost);
  out.wake_up = distribution(h.wake_up);
  out.period = distribution(h.period);
  out.clamps = cell.machine.loop().limits().clamps();
  add_components(cell, out);
  add_controllers(cell, out);
  return out;
}

LimitsList::Answer limits_list(const HealthOwners& cell, const LimitsList&) {
  LimitsList::Answer out;
  const double period = seconds(cell.machine.period());
  for (const control::Clamp& clamp : cell.machine.loop().limits().report())
    out.push_back({clamp.interface, cell.machine.controllers().holder_of(clamp.interface),
                   controllers::name(clamp.limit), clamp.count, number_or_null(clamp.asked),
                   number_or_null(clamp.given), static_cast<double>(clamp.cycle) * period});
  return out;
}

}  // namespace

std::vector<Handler> health_handlers() {
  return handlers<interfaces_list, health, limits_list>();
}

}  // namespace polyarm::cell
