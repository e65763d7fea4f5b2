#pragma once
#include <atomic>
#include <cstdint>

namespace polyarm::realtime {

enum class StopKind : std::uint32_t { none = 0, controlled = 1, immediate = 2 };

/// The word beside the loop that any thread, socket or signal handler may set and that the loop reads every
/// cycle: no queue, no lock, no living cell thread needed. It stays set until a person clears it.
class StopLatch {
 public:
  /// Never weakens a stop already asked for. Safe in signal handlers.
  void request(StopKind kind) noexcept {
    count_.fetch_add(1, std::memory_order_release);
    std::uint32_t seen = word_.load(std::memory_order_relaxed);
    while (seen < static_cast<std::uint32_t>(kind) &&
           !word_.compare_exchange_weak(seen, static_cast<std::uint32_t>(kind), std::memory_order_release)) {
    }
  }
  StopKind requested() const noexcept { return static_cast<StopKind>(word_.load(std::memory_order_acquire)); }
  /// How often a stop has been asked for.
  std::uint32_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  void clear() noexcept { word_.store(0, std::memory_order_release); }

 private:
  std::atomic<std::uint32_t> word_{0}, count_{0};
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
};

}  // namespace polyarm::realtime
