#pragma once
/// The control thread's view of the components: one call reads all, one call writes all.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/hardware/own_clock.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::hardware {

struct HostedComponent;
struct Hosting;

/// A joint whose measured position is checked for plausibility.
struct WatchedJoint {
  std::size_t state = 0;  ///< index of its position among the states
  int command = -1;       ///< index of its position command; -1 if there is none
  double velocity = 0;    ///< rad/s or m/s; infinite if not stated
};

/// The commands of one component.
struct CommandRange {
  std::size_t first = 0, count = 0;
};

/// Control thread, except watch() and measure(), which must be called before the loop runs. Nothing here
/// allocates, locks or throws.
class Exchange {
 public:
  explicit Exchange(Hosting& hosting) : hosting_(hosting) {}

  /// Checks the positions of these joints from now on; an impossible one is a fault of its component.
  void watch(const std::vector<WatchedJoint>& joints, Nanoseconds period);
  /// Enables timing of each component in each cycle.
  void measure(bool on) noexcept { measuring_ = on; }

  /// Waits for the active component that paces the loop; empty if there is none.
  std::optional<bool> await_cycle(Nanoseconds timeout) noexcept;
  /// Reports wall time that passed without cycles, during which joints may have moved.
  void skipped(Nanoseconds time) noexcept { skipped_ += time; }
  /// Adds a failed component to `faults`. It is called again in the next cycle unless switch_off_failed() was called
  /// before.
  void read(const Cycle& cycle, FaultEvents& faults) noexcept;
  void write(const Cycle& cycle, FaultEvents& faults) noexcept;

  /// Switches off the component of the event and its group. Returns the components that were on until now.
  std::span<const std::size_t> switch_off_failed(const FaultEvent& event) noexcept;
  /// The next component that was activated: its commands start again from the measured state.
  bool take_restarted(CommandRange& out) noexcept;

  /// What switched the component or another one of its group off; none: it was activated since.
  StopCause fallen(std::size_t i) const noexcept;
  /// The first simulated world among the components, or null.
  const WorldState* world() const noexcept;

 private:
  ReturnType read_one(std::size_t i, const Cycle& cycle, Exchanged& exchanged) noexcept;
  ReturnType write_one(std::size_t i, const Cycle& cycle) noexcept;
  ReturnType read_async(HostedComponent& hosted, std::span<double> states, Exchanged& exchanged) noexcept;
  void write_async(HostedComponent& hosted, const Cycle& cycle, std::span<const double> commands) noexcept;
  bool judge_state(std::size_t i, std::size_t k, double between, FaultEvents& faults) noexcept;
  void judge_states(std::size_t i, double between, FaultEvents& faults) noexcept;
  void judge_following(std::size_t i, FaultEvents& faults) noexcept;
  void judge_thread(std::size_t i, FaultEvents& faults) noexcept;
  void find_contacts(FaultEvents& faults) noexcept;
  double between_reads(HostedComponent& hosted, const Cycle& cycle, const Exchanged& exchanged) noexcept;

  Hosting& hosting_;
  std::uint32_t following_cycles_ = 250;
  Nanoseconds skipped_ = 0;  // since the start
  int contacts_seen_ = 0;    // findings of the simulated world
  bool measuring_ = false;
};

}  // namespace polyarm::hardware
