#pragma once
/// State shared by the views of Hardware. Private to the room.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/host_options.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/hardware/own_clock.hpp"
#include "polyarm/hardware/transition.hpp"
#include "polyarm/realtime/async_runner.hpp"
#include "polyarm/realtime/jobs.hpp"
#include "polyarm/realtime/overrun_watch.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::hardware {

/// The joints of a component whose measured positions are checked.
struct Watched {
  std::vector<double> last;          // NaN: not measured yet
  std::vector<double> speed;         // largest change per second, without kJumpFloor
  std::vector<std::uint32_t> state;  // indices in the table
  void forget() noexcept { std::fill(last.begin(), last.end(), std::numeric_limits<double>::quiet_NaN()); }
};
/// Command tracking of the same joints; separate from Watched, which is read every cycle.
struct Following {
  int command;               ///< -1 if there is none
  std::uint32_t behind = 0;  ///< cycles in which the joint was too far from its command
};

/// A component and everything that belongs to it.
struct HostedComponent {
  // control thread, every cycle
  bool reading = false, writing = false;
  bool late_reported = false;
  StopCause fallen = StopCause::none;
  unsigned divisor = 1;
  Nanoseconds budget = 0;
  std::unique_ptr<Component> component;
  std::unique_ptr<realtime::AsyncRunner> runner;
  std::unique_ptr<OwnClock> own_clock;  // instead of a runner
  std::size_t first_state = 0, states = 0, first_command = 0, commands = 0;
  Watched watched;
  std::vector<Following> following;  // for the same joints
  double following_error = std::numeric_limits<double>::infinity();
  Nanoseconds exchange_began = 0;  // with a thread: start of the exchange whose states were read last
  Nanoseconds skips_seen = 0;
  Nanoseconds read_at = 0, read_took = 0;
  unsigned missed_in_a_row = 0;  // for a thread that the loop triggers

  // any thread
  std::string name;
  HostOptions options;
  std::atomic<LifecycleState> state{LifecycleState::unconfigured};
  std::atomic<StopCause> failed_by{StopCause::none};  // cause of the last failure found by the loop
  std::atomic<int> failed_at{-1};                     // the interface that showed it
  std::shared_ptr<Transition> pending;                // shared with the thread that runs it
  std::string reason_before;                          // its reason when `pending` began; cell thread
  std::atomic<bool> busy{false};                      // the same, for the control thread
  std::unique_ptr<realtime::PartHealth> part = std::make_unique<realtime::PartHealth>();

  // for an async component without its own clock
  std::vector<double> own_states, own_commands;
  Cycle own_cycle;
  std::atomic<ReturnType> own_result{ReturnType::ok};
  std::atomic<bool> ran{false};  // it has read since it was activated
  Exchanged own_exchanged;       // time of that read

  bool has_thread() const noexcept { return own_clock || runner; }
};

/// A value that a fault test forces onto an interface, regardless of hardware and controllers.
struct ForcedValue {
  bool state = false;  ///< true: a state; false: a command
  std::size_t index = 0;
  double value = 0;
};

/// All components of one loop.
struct Hosting {
  Hosting(InterfaceTable& its_table, realtime::Jobs& its_jobs) : table(its_table), jobs(its_jobs) {}
  InterfaceTable& table;
  realtime::Jobs& jobs;
  std::vector<std::unique_ptr<HostedComponent>> all;
  std::vector<ForcedValue> forced;
  realtime::OverrunWatch overruns;
  realtime::Queue<std::int32_t> late{64};  // components whose thread became late
  // control thread; capacity is reserved for all components
  std::vector<std::size_t> restarted;  // activated, and not yet taken by the loop
  std::vector<std::size_t> off;        // switched off by the last switch_off_failed()
  std::atomic<int> in_call{-1};
  std::atomic<const WorldState*> world{nullptr};
  std::vector<std::string> world_names;
  int pacer = -1;  // index of the component that paces the loop
};

}  // namespace polyarm::hardware
