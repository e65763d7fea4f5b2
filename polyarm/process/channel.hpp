#pragma once
/// Messages between a process and a child of its own, both ways, through shared memory: two rings, a bell for
/// each side, and what finds no room in a ring waits in the sender's own memory, up to a bound. Messages
/// arrive whole and in order, or the channel is broken and the child has to be started anew.
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/process/shared_ring.hpp"

namespace polyarm::process {

/// Memory that another process can map by its descriptor, of a size that nobody can change any more.
class SharedMemory {
 public:
  /// New memory, zeros. Throws Error("no-process").
  explicit SharedMemory(std::size_t size);
  /// What another process made; throws where it is not of that size.
  SharedMemory(Descriptor descriptor, std::size_t size);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  std::span<std::byte> bytes() const { return bytes_; }
  int descriptor() const { return descriptor_.number(); }

 private:
  void map(std::size_t size);
  Descriptor descriptor_;
  std::span<std::byte> bytes_;
};

struct ChannelLimits {
  std::size_t most_message =
      bounds::kSampleBytes + 64 * 1024;               ///< bytes; larger ones are not sent, and break it
  std::size_t most_waiting = bounds::kExchangeBytes;  ///< bytes of what may be dropped that wait for room
  std::size_t most_messages = 10'000;                 ///< of these
  std::size_t most_ever = std::size_t{64} << 20;      ///< bytes that wait at all; beyond this it is broken
};

/// Where a child finds its end.
inline constexpr int kMemoryOfChild = 3, kBellOfChild = 4, kBellOfParent = 5;

class Channel {
 public:
  /// The parent's end of a new channel. Throws Error("no-process").
  explicit Channel(ChannelLimits limits = {});
  /// Descriptors, which it closes at the end.
  struct Inherited {
    int memory = kMemoryOfChild, own_bell = kBellOfChild, other_bell = kBellOfParent;
  };
  /// The child's end. Throws Error("no-process").
  explicit Channel(Inherited inherited, ChannelLimits limits = {});

  /// What the child is to find at kMemoryOfChild and on.
  std::array<int, 3> of_child() const;

  /// Any thread; never waits. False where it is not sent: too large, too much waits, or it is broken.
  /// `must`: too much is for the bound of what waits at all.
  bool send(std::span<const std::byte> message, bool must);
  enum class Received { message, nothing, broken };
  /// One thread: the next message. What waits for room is sent on in passing.
  Received receive(std::vector<std::byte>& message);
  /// The same thread, before it sleeps on bell(): false where there is something to receive already.
  bool may_sleep();
  /// After the sleep.
  void woken();
  int bell() const { return own_bell_.number(); }
  /// Sleeps at most so long, ms, unless there is something to do.
  void wait(int most_ms);

  bool broken() const;
  /// Messages of the other side that it has dropped, as it says.
  std::uint64_t dropped_there() const;
  /// How often the child's main loop has come round, seen by the parent.
  std::uint64_t beats() const;
  void beat();
  /// Signs of life of the child's process (pulse.hpp), seen by the parent.
  std::uint64_t pulses() const;
  void pulse();

 private:
  struct Shared;
  struct Waiting {
    std::vector<std::byte> message;
    bool must = false;
  };
  Shared& shared() const;
  std::span<std::byte> ring_bytes(int index) const;
  void ring_other() const;
  /// False where no room is left before its end; `sent` is how far it came.
  bool push(std::span<const std::byte> message, std::size_t& sent);
  void flush();

  const ChannelLimits limits_;
  SharedMemory memory_;
  Descriptor own_bell_, other_bell_;
  const bool parent_;
  RingReader reader_;
  std::vector<std::byte> partial_;

  mutable std::mutex mutex_;  ///< of what is sent
  RingWriter writer_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0, waiting_droppable_ = 0, first_sent_ = 0;
  bool broken_ = false;
};

}  // namespace polyarm::process
