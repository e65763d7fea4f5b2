#pragma once
/// A queue of frames in memory shared by two processes: one writes, one reads, neither waits. Neither side
/// trusts data that the other can change: it keeps its own position, checks the other's position against the
/// size, and copies a frame before reading it.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace polyarm::process {

/// Located at the start of the shared memory, before the frames.
struct RingState {
  alignas(64) std::atomic<std::uint64_t> written{0};  ///< total bytes
  alignas(64) std::atomic<std::uint64_t> read{0};     ///< total bytes
  alignas(64) std::atomic<std::uint32_t> asleep{0};   ///< the reader wants to be woken by the next frame
  std::atomic<std::uint32_t> full{0};                 ///< the writer wants to be woken when there is room
};

enum class RingResult {
  done,
  none,   ///< no room for the frame, or no frame
  broken  ///< the other side's state is invalid
};

/// Largest payload of one frame, bytes.
inline constexpr std::size_t kMostInFrame = 64 * 1024;

class RingWriter {
 public:
  /// The size of `bytes` must be a power of two and larger than a frame.
  RingWriter(RingState& state, std::span<std::byte> bytes) : state_{state}, bytes_{bytes} {}
  /// `last`: this frame ends its message.
  RingResult put(std::span<const std::byte> payload, bool last);

 private:
  void copy(std::uint64_t at, const void* from, std::size_t count);
  RingState& state_;
  std::span<std::byte> bytes_;
  std::uint64_t written_ = 0;
};

class RingReader {
 public:
  RingReader(RingState& state, std::span<const std::byte> bytes) : state_{state}, bytes_{bytes} {}
  /// Appends the payload of the next frame to `message`, which may grow to at most `most` bytes.
  RingResult take(std::vector<std::byte>& message, std::size_t most, bool& last);
  /// True if there is a frame, or the other side's state is invalid.
  bool something() const { return state_.written.load(std::memory_order_acquire) != read_; }
  bool half_empty() const {
    return state_.written.load(std::memory_order_relaxed) - read_ <= bytes_.size() / 2;
  }

 private:
  void copy(std::uint64_t at, void* to, std::size_t count) const;
  RingState& state_;
  std::span<const std::byte> bytes_;
  std::uint64_t read_ = 0;
};

}  // namespace polyarm::process
