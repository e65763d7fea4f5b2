#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

namespace polyarm::realtime {

/// The latest value, from one writer thread to one reader thread. Neither ever waits; the reader always gets
/// the newest whole value, and values it did not fetch in time are lost. T is made three times up front, so a
/// writer that fills it in place allocates nothing.
template <typename T>
class Latest {
 public:
  explicit Latest(const T& initial = T{}) : slots_{initial, initial, initial} {}

  /// Before either thread runs: makes all three slots equal to `value`.
  void reset(const T& value) { slots_.fill(value); }

  /// Writer: the slot to fill; call publish() when it is whole.
  T& draft() noexcept { return slots_[writing_]; }
  void publish() noexcept {
    writing_ =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void write(const T& value) noexcept(noexcept(std::declval<T&>() = value)) {
    draft() = value;
    publish();
  }

  /// Reader: fetches the newest value; true if there is one since the last call.
  bool fetch() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;
    reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// Reader: the value fetched last.
  const T& value() const noexcept { return slots_[reading_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_;
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t writing_ = 0;  // writer's
  std::uint8_t reading_ = 2;  // reader's
};

}  // namespace polyarm::realtime
