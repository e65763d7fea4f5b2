#include "polyarm/control/supervisor.hpp"

#include <algorithm>
#include <utility>

namespace polyarm::control {

const char* name(RunState state) {
  constexpr const char* kNames[] = {"running", "stopping", "held", "fault", "backing"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* name(Event event) {
  constexpr const char* kNames[] = {"stop", "standing", "resume", "discard", "fault", "recover", "back"};
  return kNames[static_cast<std::size_t>(event)];
}

const char* name(StopCause cause) {
  constexpr const char* kNames[] = {
      "nothing",
      "a stop was requested",
      "wall time was lost (the process or the machine was suspended)",
      "the cell thread was silent for 0.5 s",
      "a hardware component failed",
      "a controller failed",
      "the program ended",
      "cycles were late, one after the other",
      "a measured joint position is NaN or infinite",
      "a measured joint position jumped",
      "a joint does not follow its command",
      "a joint is far outside its limits",
      "a contact",
      "a hardware component failed",
  };
  return kNames[static_cast<std::size_t>(cause)];
}

const char* code(StopCause cause) {
  constexpr const char* kCodes[] = {"none",          "asked",   "gap",     "cell-silent",  "component",
                                    "controller",    "program", "late",    "not-a-number", "jump",
                                    "not-following", "limits",  "contact", "component"};
  return kCodes[static_cast<std::size_t>(cause)];
}

void Supervisor::enter(Event event, const FaultEvent& why) noexcept {
  if (event == Event::stop && why.cause != StopCause::asked) ++other_stops_;
  const RunState now = state();
  const RunState then = next(now, event);
  if (then == now) return;
  if (then == RunState::running || then == RunState::stopping || then == RunState::fault) {
    event_ = why;
    cause_.store(reported(why.cause), std::memory_order_release);
  }
  state_.store(then, std::memory_order_release);
}

Overrun Supervisor::when_late(const FaultEvent& event) const noexcept {
  const auto component = static_cast<std::size_t>(event.component);
  if (event.component < 0) return late_;
  return component < component_late_.size() ? component_late_[component] : Overrun::report;
}

bool Supervisor::react(const FaultEvent& event, bool contained) noexcept {
  const bool meant = event.cause == StopCause::contact && contacts_meant_.load(std::memory_order_relaxed);
  return react(event, contained, meant ? ContactStop::none : contact_stop_);
}

bool Supervisor::react(const FaultEvent& event, bool contained, ContactStop contact_stop) noexcept {
  const Reaction reaction = reaction_to(event.cause, contained, when_late(event), contact_stop);
  if (reaction.loop == Reaction::Loop::stops) enter(Event::stop, event);
  if (reaction.loop == Reaction::Loop::faults) enter(Event::fault, event);
  if (event.cause == StopCause::contact && contact_stop != ContactStop::none)
    touched_ = state() == RunState::stopping;
  return reaction.group_off;
}

void Supervisor::note_times(Nanoseconds now, bool standing) noexcept {
  const bool stops = state() == RunState::stopping || state() == RunState::fault;
  if (stops && !std::exchange(stops_, stops)) times_ = {now, -1};
  if (times_.begun >= 0 && times_.ended < 0 && times_.begun < now && standing) times_.ended = now;
  stops_ = stops;
}

controllers::Verdict Supervisor::judge(Nanoseconds now, bool standing, Request request) noexcept {
  controllers::Verdict verdict;
  const bool contact = stop_for_contact_.exchange(false, std::memory_order_acquire);
  if (contact && !(touched_ && state() == RunState::stopping)) react({StopCause::contact}, false, contact_stop_);
  const realtime::StopKind stop = latch_.requested();
  if (stop != realtime::StopKind::none) react({StopCause::asked}, false);
  if (watch_cell.load(std::memory_order_relaxed) && !standing &&
      now - heartbeat_.load(std::memory_order_relaxed) > kSilence)
    react({StopCause::cell_silent}, false);
  if ((state() == RunState::stopping || state() == RunState::backing) && standing) enter(Event::standing);
  if (request == Request::resume && stop == realtime::StopKind::none) enter(Event::resume);
  if (request == Request::recover) enter(Event::recover);
  if (request == Request::back && stop == realtime::StopKind::none) enter(Event::back);
  note_times(now, standing);
  verdict.discard = request == Request::discard && state() == RunState::held;
  const double most = share() * override_share();
  verdict.speed = state() == RunState::running ? most : 0;
  if (state() == RunState::backing) {
    verdict.back = std::min(kBackShare, most);
    verdict.back_time = back_time_.load(std::memory_order_relaxed);
    verdict.back_way = back_way_.load(std::memory_order_relaxed);
  }
  verdict.held = state() == RunState::held;
  verdict.stop_requests = latch_.count();
  verdict.stops = verdict.stop_requests + other_stops_;
  touched_ = touched_ && state() == RunState::stopping;
  verdict.immediate = stop == realtime::StopKind::immediate || state() == RunState::fault || touched_;
  verdict.cut = touched_ && contact_stop_ == ContactStop::cut;
  return verdict;
}

}  // namespace polyarm::control
