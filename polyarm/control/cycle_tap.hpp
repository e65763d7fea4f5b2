#pragma once
/// Transfers every cycle (or every n-th) from the control thread to one other thread, for recording.
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/control/supervisor.hpp"

namespace polyarm::control {

/// The facts of one recorded cycle, besides its states and commands.
struct TappedCycle {
  std::uint64_t index = 0;
  Nanoseconds time = 0;    ///< cell time
  Nanoseconds woke = 0;    ///< wake-up latency of the cycle, ns; 0 in lock-step
  Nanoseconds cost = 0;    ///< of the previous cycle, ns
  std::uint64_t late = 0;  ///< late cycles so far
  RunState state = RunState::running;
  StopCause cause = StopCause::none;
  bool standing = true;
};

/// A queue from the control thread to one other thread; all memory is allocated at construction. Neither side
/// ever waits: cycles without room are lost and counted.
class CycleTap {
 public:
  /// Room for `rows` cycles with this number of states and commands.
  CycleTap(std::size_t states, std::size_t commands, std::size_t rows, unsigned every = 1);

  /// Control thread.
  void record(const TappedCycle& cycle, std::span<const double> states,
              std::span<const double> commands) noexcept;

  /// The other thread: the oldest row, valid until drop(); null if there is none.
  const TappedCycle* front() const noexcept;
  std::span<const double> states() const noexcept;
  std::span<const double> commands() const noexcept;
  void drop() noexcept;
  /// Any thread: number of lost rows.
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
