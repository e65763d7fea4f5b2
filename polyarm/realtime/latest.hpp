#pragma once
/// Exchanges the latest value between two threads without locks.
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

namespace polyarm::realtime {

/// Passes the latest value from one writer thread to one reader thread (triple buffer). Neither thread waits.
/// The reader gets the newest complete value; older values that it did not fetch are lost. All three slots
/// are constructed up front: a writer that fills its slot in place allocates nothing.
template <typename T>
class Latest {
 public:
  explicit Latest(const T& initial = T{}) : slots_{initial, initial, initial} {}

  /// Sets all three slots to `value`. Call it before either thread runs.
  void reset(const T& value) { slots_.fill(value); }

  /// Writer: the slot to fill; call publish() when it is complete.
  T& draft() noexcept { return slots_[writing_]; }
  void publish() noexcept {
    writing_ =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void write(const T& value) noexcept(noexcept(std::declval<T&>() = value)) {
    draft() = value;
    publish();
  }

  /// Reader: fetches the newest value. Returns true if the writer published since the last call.
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
  std::uint8_t writing_ = 0;  // used by the writer only
  std::uint8_t reading_ = 2;  // used by the reader only
};

}  // namespace polyarm::realtime
