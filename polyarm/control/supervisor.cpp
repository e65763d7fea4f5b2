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
      "a stop was asked for",
      "wall time went missing (the process or the machine was suspended)",
      "the cell thread was silent for 0.5 s",
      "a hardware component failed",
      "a controller failed",
      "the program ended",
      "cycles were late, one after the other",
      "a measured joint position is no number",
      "a measured joint position jumped",
      "a joint does not follow its command",
      "a joint is far outside its limits",
      "a contact",
  };
  return kNames[static_cast<std::size_t>(cause)];
}

const char* code(StopCause cause) {
  constexpr const char* kCodes[] = {"none",    "asked", "gap",          "cell-silent", "component",
                                    "controller", "program", "late",     "not-a-number", "jump",
                                    "not-following", "limits", "contact"};
  return kCodes[static_cast<std::size_t>(cause)];
}

StopCause cause_of(const hardware::Fault& fault) noexcept {
  using hardware::FaultKind;
  switch (fault.kind) {
    case FaultKind::not_a_number:
      return StopCause::not_a_number;
    case FaultKind::jump:
      return StopCause::jump;
    case FaultKind::not_following:
      return StopCause::not_following;
    case FaultKind::late:
      return StopCause::late;
    case FaultKind::outside:
      return StopCause::limits;
    case FaultKind::controller:
      return StopCause::controller;
    default:
      return StopCause::component;
  }
}

void Supervisor::enter(Event event, StopCause cause) noexcept {
  if (event == Event::stop && cause != StopCause::asked) ++other_stops_;
  const RunState now = state();
  const RunState then = next(now, event);
  if (then == now) return;
  if (then == RunState::running) culprit_.store(-1, std::memory_order_relaxed);
  if (then == RunState::running || then == RunState::stopping || then == RunState::fault)
    cause_.store(cause, std::memory_order_release);
  state_.store(then, std::memory_order_release);
}

void Supervisor::raise(StopCause cause, std::int32_t who) noexcept {
  if (state() == RunState::fault) return;
  culprit_.store(who, std::memory_order_release);
  enter(Event::fault, cause);
}

void Supervisor::touched() noexcept {
  if (contact_stop_ == ContactStop::none) return;
  enter(Event::stop, StopCause::contact);
  touched_ = state() == RunState::stopping;
}

void Supervisor::note_times(Nanoseconds now, bool standing) noexcept {
  const bool stops = state() == RunState::stopping || state() == RunState::fault;
  if (stops && !std::exchange(stops_, stops)) times_ = {now, -1};
  if (times_.begun >= 0 && times_.ended < 0 && times_.begun < now && standing) times_.ended = now;
  stops_ = stops;
}

controllers::Verdict Supervisor::judge(const hardware::Cycle& cycle, const hardware::Fault& fault, bool gap,
                                       bool standing, Request request) noexcept {
  controllers::Verdict verdict;
  const realtime::StopKind stop = latch_.requested();
  if (fault) raise(cause_of(fault), fault.component);
  if (stop != realtime::StopKind::none) enter(Event::stop, StopCause::asked);
  if (gap) enter(Event::stop, StopCause::gap);
  if (watch_cell.load(std::memory_order_relaxed) && !standing && cycle.time - heartbeat_.load(std::memory_order_relaxed) > kSilence)
    enter(Event::stop, StopCause::cell_silent);
  if ((state() == RunState::stopping || state() == RunState::backing) && standing)
    enter(Event::standing, StopCause::none);
  if (request == Request::resume && stop == realtime::StopKind::none) enter(Event::resume, StopCause::none);
  if (request == Request::recover) enter(Event::recover, StopCause::none);
  if (request == Request::back && stop == realtime::StopKind::none) enter(Event::back, StopCause::none);
  note_times(cycle.time, standing);
  verdict.discard = request == Request::discard && state() == RunState::held;
  const double most = share() * override_share();
  verdict.speed = state() == RunState::running ? most : 0;
  if (state() == RunState::backing) {
    verdict.back = std::min(kBackShare, most);
    verdict.back_time = back_time_.load(std::memory_order_relaxed);
    verdict.back_way = back_way_.load(std::memory_order_relaxed);
  }
  verdict.held = state() == RunState::held;
  verdict.stops_asked = latch_.count();
  verdict.stops = verdict.stops_asked + other_stops_;
  touched_ = touched_ && state() == RunState::stopping;
  verdict.immediate = stop == realtime::StopKind::immediate || state() == RunState::fault || touched_;
  verdict.cut = touched_ && contact_stop_ == ContactStop::cut;
  return verdict;
}

}  // namespace polyarm::control
