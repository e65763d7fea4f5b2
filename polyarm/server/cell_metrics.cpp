#include "polyarm/server/cell_metrics.hpp"

#include <nlohmann/json.hpp>

#include "polyarm/server/metrics_text.hpp"

namespace polyarm::server {

namespace {

constexpr const char* kGauge = "gauge";
constexpr const char* kCounter = "counter";
constexpr const char* kProgramStates[] = {"none",     "ready",   "running", "waiting",
                                          "finished", "stopped", "failed"};

double seconds_of(Nanoseconds ns) {
  return seconds(ns);
}

}  // namespace

void CellMetrics::attach(cell::CellView& cell, double now) {
  sample(now);
  cell_ = &cell;
  cell.add_observer(*this);
  last_passes_ = 0;
  ++restarts_;
}

void CellMetrics::detach(double now) {
  if (!cell_) return;
  sample(now);
  cell_->remove_observer(*this);
  cell_ = nullptr;
  program_state_ = "none";
}

void CellMetrics::tick(double now) {
  if (sampled_ == 0 || now - sampled_ >= kEvery_s) sample(now);
}

/// The time since the last sample counts for the state that is found now.
void CellMetrics::sample(double now) {
  const double passed = sampled_ > 0 ? now - sampled_ : 0;
  sampled_ = now;
  if (!cell_) {
    no_cell_s_ += passed;
    return;
  }
  const control::RunState state = cell_->snapshot().state;
  state_s_[static_cast<std::size_t>(state)] += passed;
  const auto program = cell_->program_overview();
  program_state_ = program ? program->state : "none";
  program_s_[program_state_] += passed;
  const bool works = program_state_ == "running" || program_state_ == "waiting";
  if (works && state == control::RunState::running) working_s_ += passed;
  if (!program) return;
  if (program->passes > last_passes_) passes_ += program->passes - last_passes_;
  last_passes_ = program->passes;
}

void CellMetrics::on_state(Nanoseconds, const std::string& state, const Problem& cause) {
  if (state != control::name(control::RunState::fault)) return;
  const bool room = faults_.size() < kMostCauses || faults_.contains(cause.code);
  ++faults_[room ? cause.code : "other"];
}

/// Numbers of the cell with these names, which a program counts.
std::map<std::string, double> CellMetrics::parts() const {
  std::map<std::string, double> out;
  if (!cell_) return out;
  for (const auto& [quality, name] : {std::pair{"good", "parts_good"}, std::pair{"bad", "parts_bad"}})
    if (const data::Value* value = cell_->store().find(name))
      if (const data::Number* number = value->as_number()) out[quality] = number->value;
  return out;
}

std::string CellMetrics::prometheus(const Pendant::Counts& counts) const {
  MetricsText out;
  out.single("polyarm_up", kGauge, "1 while a cell runs", cell_ ? 1 : 0);
  out.family("polyarm_info", kGauge, "Name of the cell and version of Polyarm; always 1");
  out.sample(1, {{"cell", cell_ ? cell_->file().name : ""}, {"version", version_}});
  out.family("polyarm_state_seconds_total", kCounter, "Time in each state");
  for (int i = 0; i < control::kRunStates; ++i)
    out.sample(state_s_[static_cast<std::size_t>(i)],
               {{"state", control::name(static_cast<control::RunState>(i))}});
  out.sample(no_cell_s_, {{"state", "no cell"}});
  out.family("polyarm_program_seconds_total", kCounter, "Time in each state of the program");
  for (const char* state : kProgramStates)
    out.sample(program_s_.contains(state) ? program_s_.at(state) : 0, {{"state", state}});
  out.single("polyarm_working_seconds_total", kCounter,
             "Time in which the program ran and the cell was not held", working_s_);
  out.single("polyarm_program_passes_total", kCounter, "Passes of the program's outermost loop",
             static_cast<double>(passes_));
  out.family("polyarm_faults_total", kCounter, "Faults by cause");
  for (const auto& [cause, count] : faults_) out.sample(static_cast<double>(count), {{"cause", cause}});
  out.single("polyarm_cell_starts_total", kCounter, "Cells that were built since the command began",
             static_cast<double>(restarts_));
  out.single("polyarm_clients", kGauge, "Clients of the pendant's port", static_cast<double>(counts.clients));
  out.single("polyarm_requests_total", kCounter, "Requests of these clients",
             static_cast<double>(counts.requests));
  out.single("polyarm_refused_connections_total", kCounter, "Connections that were refused",
             static_cast<double>(counts.refused));
  if (!cell_) return out.text();

  const control::Snapshot& seen = cell_->snapshot();
  out.family("polyarm_state", kGauge, "1 for the present state of the cell");
  for (int i = 0; i < control::kRunStates; ++i) {
    const auto state = static_cast<control::RunState>(i);
    out.sample(seen.state == state ? 1 : 0, {{"state", control::name(state)}});
  }
  out.family("polyarm_program_state", kGauge, "1 for the present state of the program");
  for (const char* state : kProgramStates) out.sample(program_state_ == state ? 1 : 0, {{"state", state}});
  const auto program = cell_->program_overview();
  if (program && program->last_pass_s)
    out.single("polyarm_program_last_pass_seconds", kGauge, "Cell time of the last complete pass",
               *program->last_pass_s);
  if (const auto counted = parts(); !counted.empty()) {
    out.family("polyarm_parts_total", kCounter,
               "Parts by quality: the numbers parts_good and parts_bad of the cell");
    for (const auto& [quality, count] : counted) out.sample(count, {{"quality", quality}});
  }
  out.single("polyarm_simulated", kGauge, "1 if no hardware is real", cell_->arming().needed() ? 0 : 1);
  out.single("polyarm_armed", kGauge, "1 if real hardware may move", cell_->arming().armed() ? 1 : 0);
  out.single("polyarm_speed_override_ratio", kGauge, "Override of the speed",
             cell_->supervisor().override_share());

  const control::Health& health = cell_->health();
  out.single("polyarm_control_period_seconds", kGauge, "Period of the control loop",
             seconds_of(cell_->period()));
  out.single("polyarm_cycles_total", kCounter, "Control cycles", static_cast<double>(health.cycles));
  out.single("polyarm_cycles_late_total", kCounter,
             "Cycles that woke more than half a period late, or were skipped",
             static_cast<double>(health.late));
  out.single("polyarm_cycle_gaps_total", kCounter, "Gaps in wall time that did not hold the cell",
             static_cast<double>(health.gaps));
  out.single("polyarm_commands_limited_total", kCounter, "Commands that a limit changed",
             static_cast<double>(cell_->clamps()));
  const auto times = [&](const std::string& name, const realtime::Histogram& values, const char* help) {
    out.family(name, kGauge, help);
    out.sample(seconds_of(values.percentile(0.5)), {{"share", "0.5"}});
    out.sample(seconds_of(values.percentile(0.99)), {{"share", "0.99"}});
    out.sample(seconds_of(values.max()), {{"share", "1"}});
  };
  times("polyarm_cycle_cost_seconds", health.cost,
        "Duration of a control cycle that this share does not exceed");
  times("polyarm_cycle_wake_up_seconds", health.wake_up,
        "Latency of a wake-up that this share does not exceed");
  times("polyarm_cycle_period_seconds", health.period,
        "Time between two cycles that this share does not exceed");

  out.family("polyarm_hardware_active", kGauge, "1 if the hardware component is active");
  const hardware::Hardware& hardware = cell_->hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i)
    out.sample(hardware.state_of(i) == hardware::LifecycleState::active ? 1 : 0,
               {{"component", hardware.component_name(i)}});
  out.family("polyarm_robot_jogged", kGauge, "1 while a person jogs the robot");
  for (std::size_t i = 0; i < cell_->robots().size(); ++i)
    out.sample(cell_->jogged(i) ? 1 : 0, {{"robot", cell_->robots()[i]->entry.name}});
  const auto links = cell_->links().status();
  const auto of_links = [&](const char* name, const char* type, const char* help, const auto& value) {
    out.family(name, type, help);
    for (const auto& each : links)
      out.sample(value(each.state), {{"link", each.entry->name}, {"kind", each.entry->kind}});
  };
  of_links("polyarm_link_up", kGauge, "1 if the link is connected",
           [](const signals::LinkState& s) { return s.up ? 1.0 : 0.0; });
  of_links("polyarm_link_losses_total", kCounter, "Times that the link was lost",
           [](const signals::LinkState& s) { return static_cast<double>(s.losses); });
  of_links("polyarm_link_exchanges_total", kCounter, "Exchanges of the link",
           [](const signals::LinkState& s) { return static_cast<double>(s.exchanges); });
  of_links("polyarm_link_round_seconds", kGauge, "Duration of the last exchange",
           [](const signals::LinkState& s) { return seconds_of(s.round_ns); });
  return out.text();
}

nlohmann::json CellMetrics::summary(const Pendant::Counts& counts) const {
  nlohmann::json out{{"version", version_},     {"clients", counts.clients}, {"passes", passes_},
                     {"working_s", working_s_}, {"no_cell_s", no_cell_s_},   {"faults", faults_},
                     {"program_s", program_s_}};
  for (int i = 0; i < control::kRunStates; ++i)
    out["state_s"][control::name(static_cast<control::RunState>(i))] = state_s_[static_cast<std::size_t>(i)];
  if (!cell_) {
    out["state"] = "no cell";
    return out;
  }
  const control::Snapshot& seen = cell_->snapshot();
  out["cell"] = cell_->file().name;
  out["state"] = control::name(seen.state);
  if (seen.state != control::RunState::running) {
    const Problem cause = cell_->stop_cause();
    out["cause"] = {{"code", cause.code}, {"what", cause.what}, {"advice", cause.advice}};
  }
  if (cell_->failure()) out["failure"] = cell_->failure()->problem.text();
  out["simulated"] = !cell_->arming().needed();
  out["armed"] = cell_->arming().armed();
  out["time_s"] = seconds_of(cell_->now());
  out["parts"] = parts();
  out["cycles"] = static_cast<std::uint64_t>(cell_->health().cycles);
  out["late"] = static_cast<std::uint64_t>(cell_->health().late);
  for (const auto& robot : cell_->robots()) out["robots"].push_back(robot->entry.name);
  if (const auto program = cell_->program_overview()) {
    out["program"] = {{"name", program->name},
                      {"state", program->state},
                      {"hash", program->hash},
                      {"passes", program->passes}};
    if (program->last_pass_s) out["program"]["last_pass_s"] = *program->last_pass_s;
    if (program->problem) out["program"]["problem"] = program->problem->what;
  }
  for (const auto& each : cell_->links().status())
    if (!each.state.up) out["links_down"].push_back(each.entry->name);
  return out;
}

}  // namespace polyarm::server
