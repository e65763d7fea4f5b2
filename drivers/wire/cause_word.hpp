#pragma once
/// Why a link failed, shared between its thread and the control loop without a lock.
#include <atomic>
#include <cstdint>

namespace polyarm::wire {

/// A cause and its detail in one atomic word. Cause{} (0) means none. Any thread.
template <class Cause>
class CauseWord {
 public:
  struct Value {
    Cause cause;
    int detail;
  };
  explicit operator bool() const noexcept { return word_.load(std::memory_order_acquire) != 0; }
  Value value() const noexcept {
    const std::uint64_t word = word_.load(std::memory_order_acquire);
    return {static_cast<Cause>(word & 0xFF), static_cast<std::int32_t>(word >> 8)};
  }
  Cause cause() const noexcept { return value().cause; }
  void set(Value value) noexcept { word_.store(packed(value), std::memory_order_release); }
  /// Keeps the first cause.
  void set_first(Value value) noexcept {
    std::uint64_t none = 0;
    word_.compare_exchange_strong(none, packed(value), std::memory_order_acq_rel);
  }
  void clear() noexcept { word_.store(0, std::memory_order_release); }

 private:
  static std::uint64_t packed(Value value) noexcept {
    return static_cast<std::uint64_t>(value.cause) |
           static_cast<std::uint64_t>(static_cast<std::uint32_t>(value.detail)) << 8;
  }
  std::atomic<std::uint64_t> word_{0};
};

}  // namespace polyarm::wire
