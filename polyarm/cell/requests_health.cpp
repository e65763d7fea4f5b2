/// Requests about interfaces, the loop and its limits.
#include <cmath>

#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

Json finite_or_null(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

double rate_of(Cell& cell, const hardware::HostedInfo& info) {
  return info.period > 0 ? 1 / seconds(info.period)
                         : 1 / seconds(cell.loop().options().period) / info.divisor;
}
double rate_of(Cell& cell, const control::ListedController& controller) {
  return controller.period > 0 ? 1 / seconds(controller.period)
                               : 1 / seconds(cell.loop().options().period) / controller.divisor;
}

namespace {

Poll interfaces_list(Cell& cell, const Json&) {
  const hardware::InterfaceTable& table = cell.loop().table();
  const control::Snapshot& seen = cell.snapshot();
  Json states = Json::array(), commands = Json::array();
  for (std::size_t i = 0; i < table.state_names().size(); ++i)
    if (!table.state_names()[i].empty())
      states.push_back({{"name", table.state_names()[i]}, {"value", finite_or_null(seen.states[i])}});
  for (std::size_t i = 0; i < table.command_names().size(); ++i) {
    const std::string& name = table.command_names()[i];
    if (!name.empty())
      commands.push_back({{"name", name},
                          {"value", finite_or_null(seen.commands[i])},
                          {"claimed_by", cell.loop().controllers().holder_of(name)}});
  }
  return at_once({{"states", states}, {"commands", commands}});
}

Json times(const realtime::Histogram& values) {
  return {{"p50_ns", values.percentile(0.5)}, {"p99_ns", values.percentile(0.99)}, {"max_ns", values.max()}};
}

/// The same, and how the samples lie.
Json distribution(const realtime::Histogram& values) {
  Json out = times(values), buckets = Json::array();
  values.quarters([&](Nanoseconds to, std::uint64_t count) {
    buckets.push_back({{"to_ns", to}, {"count", count}});
  });
  out["buckets"] = std::move(buckets);
  return out;
}

Json thread_of(const char* what, const std::string& name, double rate, bool own_clock,
               const realtime::ThreadHealth& thread) {
  return {{what, name},
          {"rate_hz", rate},
          {"own_clock", own_clock},
          {"runs", std::uint64_t{thread.runs}},
          {"late", std::uint64_t{thread.late}},
          {"missed", std::uint64_t{thread.missed}},
          {"cost", times(thread.cost)},
          {"wake_up", times(thread.wake_up)},
          {"period", times(thread.period)}};
}

/// What has its turns in the loop, as far as it has had any that were timed.
void add_part(Json& parts, const char* what, const std::string& name, double rate,
              const realtime::PartHealth& part) {
  if (part.cost.count() == 0) return;
  parts.push_back({{what, name},
                   {"rate_hz", rate},
                   {"turns", part.cost.count()},
                   {"cost", times(part.cost)},
                   {"period", times(part.period)}});
}

Poll health(Cell& cell, const Json&) {
  const control::Health& h = cell.loop().health();
  const control::Snapshot& seen = cell.snapshot();
  Json threads = Json::array(), parts = Json::array(), fallen = Json::array();
  hardware::Hardware& hardware = cell.loop().hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const std::string& name = hardware.component_name(i);
    if (i < seen.fallen.size() && seen.fallen[i] != control::StopCause::none)
      fallen.push_back({{"component", name},
                        {"cause", control::name(seen.fallen[i])},
                        {"cause_code", control::code(seen.fallen[i])}});
    const hardware::HostedInfo info = hardware.diagnostics().info(i);
    if (const realtime::ThreadHealth* thread = hardware.diagnostics().thread_health(i))
      threads.push_back(thread_of("component", name, rate_of(cell, info), info.period > 0, *thread));
    else
      add_part(parts, "component", name, rate_of(cell, info), hardware.diagnostics().part_health(i));
  }
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.thread)
      threads.push_back(thread_of("controller", c.name, rate_of(cell, c), false, *c.thread));
    else
      add_part(parts, "controller", c.name, rate_of(cell, c), *c.part);
  return at_once({{"state", control::name(seen.state)},
                  {"cause", cell.stop_cause().what},
                  {"cause_code", cell.stop_cause().code},
                  {"standing", seen.standing},
                  {"parts", parts},
                  {"override_percent", 100 * cell.loop().supervisor().override_share()},
                  {"allowed_percent", 100 * cell.loop().supervisor().share()},
                  {"last_stop", cell.stops().empty() ? Json() : json_of(cell.stops().back())},
                  {"threads", threads},
                  {"fallen", fallen},
                  {"time_s", seconds(seen.cycle.time)},
                  {"rate_hz", 1 / seconds(cell.loop().options().period)},
                  {"cycles", std::uint64_t{h.cycles}},
                  {"late", std::uint64_t{h.late}},
                  {"cost", distribution(h.cost)},
                  {"wake_up", distribution(h.wake_up)},
                  {"period", distribution(h.period)},
                  {"clamps", cell.loop().limits().clamps()}});
}

Poll limits_list(Cell& cell, const Json&) {
  Json out = Json::array();
  const double period = seconds(cell.loop().options().period);
  for (const control::Clamp& clamp : cell.loop().limits().report())
    out.push_back({{"interface", clamp.interface},
                   {"claimed_by", cell.loop().controllers().holder_of(clamp.interface)},
                   {"limit", controllers::name(clamp.limit)},
                   {"count", clamp.count},
                   {"asked", finite_or_null(clamp.asked)},
                   {"given", finite_or_null(clamp.given)},
                   {"time_s", static_cast<double>(clamp.cycle) * period}});
  return at_once(std::move(out));
}

}  // namespace

const std::vector<RequestRow>& health_rows() {
  static const std::vector<RequestRow> table = {
      {{"interfaces",
        {},
        "{states: [{name, value}], commands: [{name, value, claimed_by}]}",
        "every state and command interface",
        false},
       interfaces_list},
      {{"health",
        {},
        "{state, cause, cause_code, standing, time_s, rate_hz, cycles, late, cost, wake_up, period, clamps, "
        "parts: "
        "[{component or controller, rate_hz, turns, cost, period}], threads: [{component or controller, "
        "rate_hz, own_clock, runs, late, missed, cost, wake_up, period}], fallen: [{component, cause, "
        "cause_code}]}",
        "how the control loop is doing",
        false},
       health},
      {{"limits",
        {},
        "[{interface, claimed_by, limit, count, asked, given, time_s}]",
        "which limits took hold of commands, how often, what was asked and given the last time, and who "
        "commands now",
        false},
       limits_list},
  };
  return table;
}

}  // namespace polyarm::cell
