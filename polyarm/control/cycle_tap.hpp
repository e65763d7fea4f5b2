#pragma once
/// Cycles, one after the other, for somebody who wants them all.
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/control/supervisor.hpp"

namespace polyarm::control {

/// What a cycle was, for whoever follows every one of them.
struct TappedCycle {
  std::uint64_t index = 0;
  Nanoseconds time = 0;    ///< cell time
  Nanoseconds woke = 0;    ///< how late the cycle woke up, ns; 0 in lock-step
  Nanoseconds cost = 0;    ///< of the cycle before it, ns
  std::uint64_t late = 0;  ///< late cycles so far
  RunState state = RunState::running;
  StopCause cause = StopCause::none;
  bool standing = true;
};

/// Every n-th cycle from the control thread to one other thread, in memory that is there from the start.
/// Neither side ever waits: what finds no room is counted and lost.
class CycleTap {
 public:
  /// Room for `rows` cycles of so many states and commands.
  CycleTap(std::size_t states, std::size_t commands, std::size_t rows, unsigned every = 1);

  /// Control thread.
  void record(const TappedCycle& cycle, std::span<const double> states,
              std::span<const double> commands) noexcept;

  /// The other thread: the oldest row that is there, until drop(); null where there is none.
  const TappedCycle* front() const noexcept;
  std::span<const double> states() const noexcept;
  std::span<const double> commands() const noexcept;
  void drop() noexcept;
  /// Any thread: rows that found no room.
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  std::size_t states_, commands_;
  unsigned every_;
  std::vector<TappedCycle> heads_;
  std::vector<double> data_;
  alignas(64) std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> lost_{0};
  alignas(64) std::atomic<std::uint64_t> read_{0};
};

}  // namespace polyarm::control
