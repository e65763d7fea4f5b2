#pragma once
/// Exchanges data between the control loop and a component that runs on its own thread at its own rate.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/periodic_runner.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::hardware {

/// Start and end of an exchange with a device, ns of the monotonic clock; in lock-step of cell time. Zero: no
/// exchange.
struct Exchanged {
  Nanoseconds began = 0, ended = 0;
};

/// The loop stores its newest commands and takes the newest measured states; the thread writes and reads its
/// component once in each of its own periods. Neither waits for the other. In lock-step the exchange runs on
/// the loop's thread, in the first cycle that starts at or after the due time. Due times are whole periods
/// apart, so rounding up to a cycle does not accumulate; a period shorter than the loop's gives one exchange
/// per cycle.
class OwnClock {
 public:
  /// `component` may be replaced while the exchange is closed; `states` are the initial states.
  OwnClock(const std::unique_ptr<Component>& component, std::span<const double> states, std::size_t commands,
           Nanoseconds period, bool lock_step, realtime::ThreadOptions options);

  // --- control thread ---
  /// Starts a new session; earlier measurements and failures no longer count.
  void open() noexcept;
  /// Ends the session: the component is not called any more once exchanging() is false.
  void close() noexcept { session_.store(0); }
  /// Stores the newest commands; if `writing` is false: no commands (NaN).
  void order(const Cycle& cycle, std::span<const double> commands, bool writing) noexcept;
  /// Result, states and time of the last exchange since the previous call; empty if there was none.
  std::optional<ReturnType> take(std::span<double> states, Exchanged& exchanged) noexcept;
  /// Number of own periods in a row, in the loop's time, without a completed exchange.
  unsigned behind() const noexcept { return behind_; }
  /// The same, or the number of runs in a row that began more than half a period late, whichever is larger.
  unsigned late_in_a_row() const noexcept {
    return std::max(behind_, health_.late_in_a_row.load(std::memory_order_relaxed));
  }

  /// Call before the loop runs: reads once, before the first exchange.
  void measure();

  /// True while the component may be in a call. Any thread may wait for its end after close().
  std::shared_ptr<const std::atomic<bool>> exchanging() const noexcept { return exchanging_; }
  Nanoseconds period() const noexcept { return period_; }
  const realtime::ThreadHealth& health() const noexcept { return health_; }

  /// A thread without new commands from the loop for this long, and for three of the loop's cycles, stops
  /// calling its component; the device's own watchdog then decides.
  static constexpr Nanoseconds kSilence = 100'000'000;

 private:
  struct Packet {
    std::uint32_t session = 0;
    ReturnType result = ReturnType::ok;
    Cycle cycle;
    Exchanged exchanged;
    std::vector<double> values;
  };
  bool exchange() noexcept;  // the thread; in lock-step the loop's thread
  Nanoseconds clock(const Cycle& order) const noexcept;

  const std::unique_ptr<Component>& component_;
  Nanoseconds period_;
  bool lock_step_;
  realtime::Latest<Packet> orders_, results_;
  std::atomic<std::uint32_t> session_{0};  // 0: closed
  std::shared_ptr<std::atomic<bool>> exchanging_ = std::make_shared<std::atomic<bool>>(false);
  realtime::ThreadHealth health_;

  // control thread
  std::uint32_t sessions_ = 0;
  Nanoseconds due_ = 0;
  bool fresh_ = true;
  unsigned behind_ = 0;

  // the component's thread
  std::vector<double> states_;
  std::uint64_t index_ = 0;
  std::uint32_t failed_ = 0;  // the session that ended with a failure
  Nanoseconds silent_ = 0;    // since the last new order

  std::unique_ptr<realtime::PeriodicRunner> runner_;  // last member: its thread ends first
};

}  // namespace polyarm::hardware
