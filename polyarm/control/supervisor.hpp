#pragma once
/// The supervisor decides on the reaction to every fault. One table defines the transitions; a test checks
/// the table.
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/realtime/stop_latch.hpp"

namespace polyarm::control {

/// running → stopping (on the path, within limits) → held → resume | discard | backing → held; any → fault →
/// recover → held.
enum class RunState : std::uint8_t { running, stopping, held, fault, backing };
enum class Event : std::uint8_t { stop, standing, resume, discard, fault, recover, back };
constexpr int kRunStates = 5, kEvents = 7;
const char* name(RunState state);
const char* name(Event event);

/// The state table: next state by present state and event.
constexpr std::array<std::array<RunState, kEvents>, kRunStates> kNextState = {{
    // stop               standing            resume              discard             fault            recover
    // back
    {{RunState::stopping, RunState::running, RunState::running, RunState::running, RunState::fault,
      RunState::running, RunState::running}},
    {{RunState::stopping, RunState::held, RunState::stopping, RunState::stopping, RunState::fault,
      RunState::stopping, RunState::stopping}},
    {{RunState::held, RunState::held, RunState::running, RunState::held, RunState::fault, RunState::held,
      RunState::backing}},
    {{RunState::fault, RunState::fault, RunState::fault, RunState::fault, RunState::fault, RunState::held,
      RunState::fault}},
    {{RunState::stopping, RunState::held, RunState::backing, RunState::backing, RunState::fault,
      RunState::backing, RunState::backing}},
}};
constexpr RunState next(RunState state, Event event) {
  return kNextState[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

using hardware::FaultEvent;
using hardware::kStopCauses;
using hardware::StopCause;
/// Reaction to late cycles in a row. (A single late cycle is only counted; a gap of half a second has its own
/// rule, LoopOptions::stall_holds.)
using Overrun = hardware::WhenLate;
/// Text for people: "a contact".
const char* name(StopCause cause);
/// A code that is the same in every language: "contact".
const char* code(StopCause cause);

/// A request from a person or the cell; the loop takes at most one per cycle.
enum class Request : std::uint8_t { none, resume, discard, recover, back };

/// Reaction to a contact in a simulated world.
enum class ContactStop : std::uint8_t {
  none,  ///< only reported
  path,  ///< stop on the path with the joints' maximum braking (category 1)
  cut,   ///< each joint brakes at once by itself and leaves the path (category 0)
};

/// The reaction to a fault event.
struct Reaction {
  enum class Loop : std::uint8_t { keeps_going, stops, faults };
  Loop loop = Loop::keeps_going;  ///< stops: on the path, then held
  bool group_off = false;     ///< switch off its component and the component's group
  friend constexpr bool operator==(const Reaction&, const Reaction&) = default;
};

/// The reaction table. `contained`: the fault affects only the group of its component (`on_fault: group`).
/// `late` and `contact`: settings of the cell file.
constexpr Reaction reaction_to(StopCause cause, bool contained, Overrun late, ContactStop contact) noexcept {
  using enum Reaction::Loop;
  switch (cause) {
    case StopCause::none:
      return {keeps_going, false};
    case StopCause::asked:
    case StopCause::gap:
    case StopCause::cell_silent:
    case StopCause::program:
      return {stops, false};
    case StopCause::contact:
      return {contact == ContactStop::none ? keeps_going : stops, false};
    case StopCause::late:
      if (late != Overrun::fault) return {late == Overrun::hold ? stops : keeps_going, false};
      [[fallthrough]];
    case StopCause::component:
    case StopCause::deactivated:
    case StopCause::not_a_number:
    case StopCause::jump:
    case StopCause::not_following:
      return {contained ? keeps_going : faults, true};
    case StopCause::controller:
    case StopCause::limits:  // the hardware works, so it stays on and brakes
      return {contained ? keeps_going : faults, contained};
  }
  return {faults, false};
}

/// Cell times at which the newest stop began and at which all motion had ended; -1: not yet.
struct StopTimes {
  Nanoseconds begun = -1, ended = -1;
};

/// judge(): control thread. The latch and the heartbeat: any thread.
class Supervisor {
 public:
  /// The loop stops if the cell thread sends no heartbeat for this long while something moves, ns.
  static constexpr Nanoseconds kSilence = 500'000'000;
  /// Maximum share of the planned speed for stepping back.
  static constexpr double kBackShare = 0.1;

  realtime::StopLatch& latch() noexcept { return latch_; }
  /// The cell thread's heartbeat; `now` is cell time.
  void heartbeat(Nanoseconds now) noexcept { heartbeat_.store(now, std::memory_order_relaxed); }

  /// Decides on the reaction to a fault event and changes the state. Returns true if the event's component
  /// and its group must be switched off. The first of several faults remains the cause. Control thread.
  bool react(const FaultEvent& event, bool contained) noexcept;
  /// The verdict of this cycle, after the fault events of its read. `standing`: no controller requested
  /// motion in the previous cycle. Control thread.
  controllers::Verdict judge(Nanoseconds now, bool standing, Request request) noexcept;

  /// Call before the loop runs: reactions to late cycles and to late threads of components.
  void set_when_late(Overrun of_loop, std::vector<Overrun> of_components = {}) {
    late_ = of_loop;
    component_late_ = std::move(of_components);
  }
  /// Call before the loop runs.
  void set_contact_stop(ContactStop stop) noexcept { contact_stop_ = stop; }
  ContactStop contact_stop() const noexcept { return contact_stop_; }
  /// While it is true, contacts do not stop the robots by themselves: the cell thread, which knows which contacts
  /// are meant, calls stop_for_contact(). Any thread.
  void set_contacts_meant(bool meant) noexcept { contacts_meant_.store(meant, std::memory_order_relaxed); }
  /// Stops the robots for a contact that is not meant, as set_contact_stop() says, also while others are meant.
  /// Any thread.
  void stop_for_contact() noexcept { stop_for_contact_.store(true, std::memory_order_release); }

  RunState state() const noexcept { return state_.load(std::memory_order_acquire); }
  StopCause cause() const noexcept { return cause_.load(std::memory_order_acquire); }
  /// The event that led to this state; its cause is none while running. Control thread.
  const FaultEvent& event() const noexcept { return event_; }
  /// Allowed share of the planned speed while running, (0, 1]. Any thread.
  void set_share(double share) noexcept { share_.store(share, std::memory_order_relaxed); }
  double share() const noexcept { return share_.load(std::memory_order_relaxed); }
  /// The user's override in [0, 1]; multiplied with the share. At 0 all motion pauses, and continues when it
  /// is raised. Any thread.
  void set_override(double share) noexcept { override_.store(share, std::memory_order_relaxed); }
  double override_share() const noexcept { return override_.load(std::memory_order_relaxed); }
  /// Distance of the next Request::back: s of the plan, and distance along the path. Call before posting that
  /// request.
  void set_back(double time, double way) noexcept {
    back_time_.store(time, std::memory_order_relaxed);
    back_way_.store(way, std::memory_order_relaxed);
  }
  /// Control thread.
  const StopTimes& stop_times() const noexcept { return times_; }
  /// Off in lock-step, where the cell thread cannot fall behind, and if a stall does not hold.
  std::atomic<bool> watch_cell{true};

 private:
  void enter(Event event, const FaultEvent& why = {}) noexcept;
  Overrun when_late(const FaultEvent& event) const noexcept;
  bool react(const FaultEvent& event, bool contained, ContactStop contact_stop) noexcept;
  void note_times(Nanoseconds now, bool standing) noexcept;

  std::uint32_t other_stops_ = 0;  // control thread
  realtime::StopLatch latch_;
  std::atomic<Nanoseconds> heartbeat_{0};
  std::atomic<RunState> state_{RunState::running};
  std::atomic<StopCause> cause_{StopCause::none};
  FaultEvent event_;
  std::atomic<double> share_{1}, override_{1}, back_time_{0}, back_way_{0};
  StopTimes times_;
  bool stops_ = false;  // in the previous cycle
  ContactStop contact_stop_ = ContactStop::none;
  std::atomic<bool> contacts_meant_{false}, stop_for_contact_{false};
  Overrun late_ = Overrun::report;
  std::vector<Overrun> component_late_;
  bool touched_ = false;  // the current stop brakes harder because of a contact
};

}  // namespace polyarm::control
