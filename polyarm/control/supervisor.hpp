#pragma once
/// The one place where faults become stops. One table says what follows what; the table is a test.
#include <array>
#include <atomic>
#include <cstdint>

#include "polyarm/base/time.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/realtime/stop_latch.hpp"

namespace polyarm::control {

/// running → stopping (on the path, within limits) → held → resume | discard | backing → held; any → fault →
/// recover → held.
enum class RunState : std::uint8_t { running, stopping, held, fault, backing };
enum class Event : std::uint8_t { stop, standing, resume, discard, fault, recover, back };
constexpr int kRunStates = 5, kEvents = 7;
const char* name(RunState state);
const char* name(Event event);

/// The state table: what each event leads to in each state.
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

/// Why the robot is not running.
enum class StopCause : std::uint8_t {
  none,
  asked,
  gap,
  cell_silent,
  component,
  controller,
  program,
  late,
  not_a_number,
  jump,
  not_following,
  limits,
  contact,
};
constexpr int kStopCauses = 13;
const char* name(StopCause cause);
/// One word that stays the same in every language: "contact".
const char* code(StopCause cause);
/// What a fault of the hardware is to the loop.
StopCause cause_of(const hardware::Fault& fault) noexcept;

/// What a person or the cell asks of the supervisor; taken once each cycle.
enum class Request : std::uint8_t { none, resume, discard, recover, back };

/// What a contact in a simulated world leads to: it is only reported; a stop on the path as hard as the joints
/// can (category 1); each joint brakes by itself at once and the path is left (category 0).
enum class ContactStop : std::uint8_t { none, path, cut };

/// When the newest stop began and when all stood, cell time; -1: not yet.
struct StopTimes {
  Nanoseconds begun = -1, ended = -1;
};

/// judge(): the control thread. The latch and the heartbeat: any thread.
class Supervisor {
 public:
  /// The loop stops by itself when the cell thread is silent for this long while something moves.
  static constexpr Nanoseconds kSilence = 500'000'000;
  /// Stepping back goes at most at this share of the planned speed.
  static constexpr double kBackShare = 0.1;

  realtime::StopLatch& latch() noexcept { return latch_; }
  /// The cell thread's sign of life; `now` is the cell's time.
  void heartbeat(Nanoseconds now) noexcept { heartbeat_.store(now, std::memory_order_relaxed); }

  /// The verdict of this cycle. `gap`: wall time has gone missing before this cycle. `standing`: no
  /// controller asked for motion in the cycle before.
  controllers::Verdict judge(const hardware::Cycle& cycle, const hardware::Fault& fault, bool gap,
                             bool standing, Request request) noexcept;
  /// A fault found after judging, for the next cycle. In a fault already, the first cause stays.
  void raise(StopCause cause, std::int32_t who) noexcept;
  /// A reason to stop on the path and hold, found outside of judging. Control thread.
  void hold(StopCause cause) noexcept { enter(Event::stop, cause); }

  /// Something touched what it should not have. Control thread.
  void touched() noexcept;
  /// Before the loop runs.
  void set_contact_stop(ContactStop stop) noexcept { contact_stop_ = stop; }
  ContactStop contact_stop() const noexcept { return contact_stop_; }

  RunState state() const noexcept { return state_.load(std::memory_order_acquire); }
  StopCause cause() const noexcept { return cause_.load(std::memory_order_acquire); }
  /// Index of the component, the controller or (of a joint outside its limits) the command at fault, -1 for
  /// none.
  std::int32_t culprit() const noexcept { return culprit_.load(std::memory_order_acquire); }
  /// How much of the planned speed may be used while running, (0, 1]. Any thread.
  void set_share(double share) noexcept { share_.store(share, std::memory_order_relaxed); }
  double share() const noexcept { return share_.load(std::memory_order_relaxed); }
  /// What people ask for beside it, [0, 1]; both multiply. At 0 all stands, and goes on by itself at more.
  /// Any thread.
  void set_override(double share) noexcept { override_.store(share, std::memory_order_relaxed); }
  double override_share() const noexcept { return override_.load(std::memory_order_relaxed); }
  /// How far the next Request::back goes: s of the plan, and along the path. Before that is posted.
  void set_back(double time, double way) noexcept {
    back_time_.store(time, std::memory_order_relaxed);
    back_way_.store(way, std::memory_order_relaxed);
  }
  /// Control thread.
  const StopTimes& stop_times() const noexcept { return times_; }
  /// Off in lock-step, where the cell cannot fall silent, and where a stall holds nothing.
  std::atomic<bool> watch_cell{true};

 private:
  void enter(Event event, StopCause cause) noexcept;
  void note_times(Nanoseconds now, bool standing) noexcept;

  std::uint32_t other_stops_ = 0;  // control thread
  realtime::StopLatch latch_;
  std::atomic<Nanoseconds> heartbeat_{0};
  std::atomic<RunState> state_{RunState::running};
  std::atomic<StopCause> cause_{StopCause::none};
  std::atomic<std::int32_t> culprit_{-1};
  std::atomic<double> share_{1}, override_{1}, back_time_{0}, back_way_{0};
  StopTimes times_;
  bool stops_ = false;  // in the cycle before
  ContactStop contact_stop_ = ContactStop::none;
  bool touched_ = false;  // the stop under way is harder for a contact
};

}  // namespace polyarm::control
