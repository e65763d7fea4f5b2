#pragma once
/// The stop request shared by all threads and the control loop.
#include <atomic>
#include <cstdint>

namespace polyarm::realtime {

enum class StopKind : std::uint32_t { none = 0, controlled = 1, immediate = 2 };

/// Stop request that any thread, socket or signal handler may set and that the loop reads every cycle. It
/// needs no queue, no lock and no running cell thread. It stays set until a person clears it.
class StopLatch {
 public:
  /// Never weakens an earlier request. Safe in signal handlers.
  void request(StopKind kind) noexcept {
    count_.fetch_add(1, std::memory_order_release);
    std::uint32_t seen = word_.load(std::memory_order_relaxed);
    while (seen < static_cast<std::uint32_t>(kind) &&
           !word_.compare_exchange_weak(seen, static_cast<std::uint32_t>(kind), std::memory_order_release)) {
    }
  }
  StopKind requested() const noexcept { return static_cast<StopKind>(word_.load(std::memory_order_acquire)); }
  /// Number of stop requests so far.
  std::uint32_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  void clear() noexcept { word_.store(0, std::memory_order_release); }

 private:
  std::atomic<std::uint32_t> word_{0}, count_{0};
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
};

}  // namespace polyarm::realtime
