#include "polyarm/process/shared_ring.hpp"

#include <algorithm>
#include <cstring>

namespace polyarm::process {

namespace {
/// The header of each frame: length of the payload, and whether the frame is the last of its message. Frames
/// are aligned to 8 bytes.
struct FrameHead {
  std::uint32_t length = 0, last = 0;
};
static_assert(sizeof(FrameHead) == 8 && std::atomic<std::uint64_t>::is_always_lock_free);

std::uint64_t whole_frame(std::size_t payload) {
  return sizeof(FrameHead) + (payload + 7) / 8 * 8;
}
}  // namespace

void RingWriter::copy(std::uint64_t at, const void* from, std::size_t count) {
  const std::size_t begin = at & (bytes_.size() - 1), first = std::min(count, bytes_.size() - begin);
  std::memcpy(bytes_.data() + begin, from, first);
  if (first < count) std::memcpy(bytes_.data(), static_cast<const std::byte*>(from) + first, count - first);
}

RingResult RingWriter::put(std::span<const std::byte> payload, bool last) {
  const std::uint64_t used = written_ - state_.read.load(std::memory_order_acquire);
  if (used > bytes_.size() || payload.size() > kMostInFrame) return RingResult::broken;
  const std::uint64_t wanted = whole_frame(payload.size());
  if (wanted > bytes_.size() - used) return RingResult::none;
  const FrameHead head{static_cast<std::uint32_t>(payload.size()), last ? 1u : 0u};
  copy(written_, &head, sizeof head);
  if (!payload.empty()) copy(written_ + sizeof head, payload.data(), payload.size());
  written_ += wanted;
  state_.written.store(written_, std::memory_order_release);
  return RingResult::done;
}

void RingReader::copy(std::uint64_t at, void* to, std::size_t count) const {
  const std::size_t begin = at & (bytes_.size() - 1), first = std::min(count, bytes_.size() - begin);
  std::memcpy(to, bytes_.data() + begin, first);
  if (first < count) std::memcpy(static_cast<std::byte*>(to) + first, bytes_.data(), count - first);
}

RingResult RingReader::take(std::vector<std::byte>& message, std::size_t most, bool& last) {
  const std::uint64_t there = state_.written.load(std::memory_order_acquire) - read_;
  if (there == 0) return RingResult::none;
  if (there > bytes_.size() || there < sizeof(FrameHead)) return RingResult::broken;
  FrameHead head;
  copy(read_, &head, sizeof head);
  const std::size_t length = head.length;
  // Every frame of a message but the last must be full, so a message needs few frames.
  if (length > kMostInFrame || (head.last == 0 && length != kMostInFrame) || head.last > 1 ||
      whole_frame(length) > there || message.size() > most || length > most - message.size())
    return RingResult::broken;
  const std::size_t before = message.size();
  message.resize(before + length);
  if (length > 0) copy(read_ + sizeof head, message.data() + before, length);
  last = head.last == 1;
  read_ += whole_frame(length);
  state_.read.store(read_, std::memory_order_release);
  return RingResult::done;
}

}  // namespace polyarm::process
