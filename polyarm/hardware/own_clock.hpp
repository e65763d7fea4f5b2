#pragma once
/// How a component that runs at a rate of its own, on a thread of its own, and the control loop meet.
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

/// When an exchange with a device began and ended, ns of the monotonic clock; in lock-step of cell time. Zero:
/// there was none.
struct Exchanged {
  Nanoseconds began = 0, ended = 0;
};

/// The loop leaves its newest commands and takes the newest measured states; the thread writes and reads its
/// component once in each of its own periods. Neither waits for the other. In lock-step the exchange is done
/// in the loop's thread, in the first cycle that does not begin before the exchange is due: due times lie
/// whole periods apart, so rounding up to a cycle does not add up, and a period shorter than the loop's
/// means one exchange each cycle.
class OwnClock {
 public:
  /// `component` may be replaced while the exchange is closed; `states` is what they begin with.
  OwnClock(const std::unique_ptr<Component>& component, std::span<const double> states, std::size_t commands,
           Nanoseconds period, bool lock_step, realtime::ThreadOptions options);

  // --- control thread ---
  /// A new session: what was measured or went wrong before counts no more.
  void open() noexcept;
  /// The component is called no more, once exchanging() is over.
  void close() noexcept { session_.store(0); }
  /// The newest commands; `writing` false: none (NaN).
  void order(const Cycle& cycle, std::span<const double> commands, bool writing) noexcept;
  /// How the last exchange since this was asked went, what it measured, and when; none: there was none.
  std::optional<ReturnType> take(std::span<double> states, Exchanged& exchanged) noexcept;
  /// Own periods in a row, of the loop's time, in which no exchange came to its end.
  unsigned behind() const noexcept { return behind_; }
  /// The same, or runs in a row that began more than half a period late, whichever is more.
  unsigned late_in_a_row() const noexcept {
    return std::max(behind_, health_.late_in_a_row.load(std::memory_order_relaxed));
  }

  /// Before the loop runs: reads once, ahead of the first exchange.
  void measure();

  /// The component may be in a call. Any thread may wait for its end once the exchange is closed.
  std::shared_ptr<const std::atomic<bool>> exchanging() const noexcept { return exchanging_; }
  Nanoseconds period() const noexcept { return period_; }
  const realtime::ThreadHealth& health() const noexcept { return health_; }

  /// A thread whose loop has given no commands for this long, and three of the loop's cycles, leaves its
  /// component alone: what the device does without commands is for its own watchdog.
  static constexpr Nanoseconds kSilence = 100'000'000;

 private:
  struct Packet {
    std::uint32_t session = 0;
    ReturnType result = ReturnType::ok;
    Cycle cycle;
    Exchanged exchanged;
    std::vector<double> values;
  };
  bool exchange() noexcept;  // the thread; in lock-step the loop's
  Nanoseconds clock(const Cycle& order) const noexcept;

  const std::unique_ptr<Component>& component_;
  Nanoseconds period_;
  bool lock_step_;
  realtime::Latest<Packet> orders_, results_;
  std::atomic<std::uint32_t> session_{0};  // 0: closed
  std::shared_ptr<std::atomic<bool>> exchanging_ = std::make_shared<std::atomic<bool>>(false);
  realtime::ThreadHealth health_;

  // the control thread's
  std::uint32_t sessions_ = 0;
  Nanoseconds due_ = 0;
  bool fresh_ = true;
  unsigned behind_ = 0;

  // the thread's
  std::vector<double> states_;
  std::uint64_t index_ = 0;
  std::uint32_t failed_ = 0;  // the session that ended with a failure
  Nanoseconds silent_ = 0;    // since the last new order

  std::unique_ptr<realtime::PeriodicRunner> runner_;  // last: its thread ends before the rest goes
};

}  // namespace polyarm::hardware
