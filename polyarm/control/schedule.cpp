#include "polyarm/control/schedule.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::control {

using controllers::CallbackReturn;
using controllers::ReturnType;
using hardware::LifecycleState;

namespace {
void copy_some(const std::vector<std::size_t>& which, std::span<const double> from, std::span<double> to) {
  for (const std::size_t i : which) to[i] = from[i];
}

/// True if an update at its own rate is due in this cycle.
bool is_due(unsigned divisor, Nanoseconds period, const hardware::Cycle& cycle) noexcept {
  if (period == 0) return cycle.index % divisor == 0;
  const Nanoseconds last = cycle.time - cycle.period;
  return last < 0 || cycle.time / period != last / period;
}
/// The cycle with the period of the own rate.
hardware::Cycle longer(hardware::Cycle cycle, unsigned divisor, Nanoseconds period) noexcept {
  cycle.period = period > 0 ? period : cycle.period * divisor;
  return cycle;
}
}  // namespace

ReturnType ControllerManager::run_async(Slot& s, const hardware::Cycle& cycle,
                                        const controllers::Verdict& verdict) noexcept {
  if (!s.runner->idle()) {
    s.runner->note_missed();
    return ReturnType::ok;
  }
  const ReturnType last = s.own_result.load(std::memory_order_acquire);
  copy_some(s.commands, s.own_commands, table_.commands());
  copy_some(s.exported, s.own_states, table_.states());
  if (last != ReturnType::ok) return last;
  std::copy(table_.states().begin(), table_.states().end(), s.own_states.begin());
  copy_some(s.references, table_.commands(), s.own_commands);
  s.own_cycle = cycle;
  s.own_verdict = verdict;
  s.runner->trigger();
  return ReturnType::ok;
}

inline ReturnType ControllerManager::run(Slot& s, const hardware::Cycle& cycle,
                                         const controllers::Verdict& verdict) noexcept {
  if (s.runner) return run_async(s, cycle, verdict);
  in_call_.store(s.id, std::memory_order_relaxed);
  const ReturnType out = overruns_.timed(s.budget, s.id, "update", cycle.index,
                                         [&] { return s.controller->update(cycle, verdict); });
  in_call_.store(-1, std::memory_order_relaxed);
  return out;
}

void ControllerManager::update(const hardware::Cycle& cycle, const controllers::Verdict& verdict,
                               hardware::FaultEvents& faults) noexcept {
  now_ = cycle;
  jobs_.run_one();
  realtime::Laps laps(measuring_);
  for (Schedule::Entry& entry : schedule_->entries) {
    Slot& s = *entry.slot;
    if (!s.active) {
      if (s.runner && s.runner->idle() && s.own_stop.exchange(false)) s.controller->on_deactivate(cycle);
      continue;
    }
    ReturnType result;
    if (entry.divisor == 1 && entry.period == 0) {
      result = run(s, cycle, verdict);
    } else {
      if (!is_due(entry.divisor, entry.period, cycle)) continue;
      result = run(s, longer(cycle, entry.divisor, entry.period), verdict);
    }
    const Nanoseconds began = laps.began(), took = laps.next();
    if (laps.on() && !s.runner) s.part->note(began, took);
    s.updates.store(s.updates.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (s.controller->command_watch().take_reports())
      events_.push({LoopEvent::Kind::commands_stale, s.id, cycle.index});
    if (result == ReturnType::ok || !entry.fall) continue;
    const bool somebody_takes_over = !entry.fall->start.empty();
    fall(*entry.fall, &s, cycle);
    if (!somebody_takes_over || entry.fall->refused)
      faults.push({hardware::StopCause::controller, entry.home, -1, s.id});
  }
}

void ControllerManager::start(Slot& s, const hardware::Cycle& cycle, Commit& commit) noexcept {
  if (s.active) return;
  if (s.runner) {
    if (!s.runner->idle()) {
      if (!commit.refused) commit.refused = &s;
      return;
    }
    std::copy(table_.states().begin(), table_.states().end(), s.own_states.begin());
    std::copy(table_.commands().begin(), table_.commands().end(), s.own_commands.begin());
    s.own_result.store(ReturnType::ok);
    s.own_stop.store(false);
    s.runner->forgive();
  }
  if (s.controller->on_activate(longer(cycle, s.options.divisor, s.options.period)) !=
      CallbackReturn::success) {
    if (!commit.refused) commit.refused = &s;
    return;
  }
  if (s.runner) copy_some(s.commands, s.own_commands, table_.commands());
  s.active = true;
  s.state.store(LifecycleState::active, std::memory_order_release);
}

void ControllerManager::stop(Slot& s, const hardware::Cycle& cycle) noexcept {
  if (!s.active) return;
  s.active = false;
  s.part->pause();
  if (s.runner && !s.runner->idle()) {
    s.own_stop.store(true);  // its thread calls on_deactivate when it has finished
  } else {
    s.controller->on_deactivate(cycle);
    if (s.runner) copy_some(s.commands, s.own_commands, table_.commands());
  }
  s.state.store(LifecycleState::inactive, std::memory_order_release);
}

void ControllerManager::execute(Commit& commit, const hardware::Cycle& cycle) noexcept {
  commit.refused = nullptr;
  for (Slot* s : commit.stop) stop(*s, cycle);
  for (const auto& [s, chained] : commit.chains) {
    s->controller->set_chained(chained);
    s->chained.store(chained, std::memory_order_relaxed);
  }
  if (!commit.start_interfaces.empty() || !commit.stop_interfaces.empty())
    hardware_.perform_mode_switch(commit.start_interfaces, commit.stop_interfaces);
  for (Slot* s : commit.start)
    if (!commit.refused) start(*s, cycle, commit);
  release_now(commit);
}

/// Sets velocities and efforts that nobody commands any more to zero; otherwise the joint would keep moving.
void ControllerManager::release_now(const Commit& commit) noexcept {
  const std::span<double> commands = table_.commands();
  const auto end = [&](std::size_t i) {
    if (std::isfinite(commands[i])) commands[i] = 0;
  };
  for (const std::size_t i : commit.left) end(i);
  if (!commit.refused) return;
  for (const Slot* s : commit.start)  // controllers that should have taken over but did not start
    if (!s->active) std::for_each(s->pushes.begin(), s->pushes.end(), end);
}

void ControllerManager::fall(Commit& commit, const Slot* culprit, const hardware::Cycle& cycle) noexcept {
  using Kind = LoopEvent::Kind;
  ++epoch_;
  if (culprit) events_.push(LoopEvent{Kind::controller_failed, culprit->id, cycle.index});
  for (const Slot* s : commit.stop)
    if (s != culprit && s->active) events_.push(LoopEvent{Kind::controller_stopped, s->id, cycle.index});
  execute(commit, cycle);
  for (const Slot* s : commit.start)
    if (s->active) events_.push(LoopEvent{Kind::fallback_started, s->id, cycle.index});
}

void ControllerManager::component_failed(std::size_t component, bool deactivated,
                                         const hardware::Cycle& cycle) noexcept {
  using Kind = LoopEvent::Kind;
  events_.push(LoopEvent{deactivated ? Kind::component_deactivated : Kind::component_failed,
                         static_cast<std::int32_t>(component), cycle.index});
  if (component < schedule_->component_failures.size())
    fall(*schedule_->component_failures[component], nullptr, cycle);
  else
    ++epoch_;
}

bool ControllerManager::contains(std::int32_t component) const noexcept {
  const auto i = static_cast<std::size_t>(component);
  return component >= 0 && i < schedule_->contained.size() && schedule_->contained[i] != 0;
}

bool ControllerManager::standing() const noexcept {
  for (const Schedule::Entry& entry : schedule_->entries)
    if (entry.slot->active && !entry.controller->standing()) return false;
  return true;
}

}  // namespace polyarm::control
