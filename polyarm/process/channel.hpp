#pragma once
/// Messages in both directions between a process and its child, through shared memory: two rings, and a
/// wake-up descriptor for each side. Messages that do not fit into a ring wait in the sender's memory, up to
/// a limit. Messages arrive complete and in order, or the channel is broken and the child must be restarted.
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

/// Memory that another process can map by its descriptor. Its size is sealed.
class SharedMemory {
 public:
  /// New memory, zeros. Throws Error("no-process").
  explicit SharedMemory(std::size_t size);
  /// Maps memory that another process made. Throws if its size differs.
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
  std::size_t most_waiting = bounds::kExchangeBytes;  ///< limit for droppable messages that wait for room,
                                                      ///< bytes
  std::size_t most_messages = 10'000;                 ///< limit for droppable messages that wait, count
  std::size_t most_ever = std::size_t{64} << 20;      ///< limit for all waiting messages, bytes; beyond it
                                                      ///< the channel breaks
};

/// The descriptors of the child's end.
inline constexpr int kMemoryOfChild = 3, kWakeupOfChild = 4, kWakeupOfParent = 5;

class Channel {
 public:
  /// The parent's end of a new channel. Throws Error("no-process").
  explicit Channel(ChannelLimits limits = {});
  /// Descriptor numbers. The channel closes them in its destructor.
  struct Inherited {
    int memory = kMemoryOfChild, own_wakeup = kWakeupOfChild, other_wakeup = kWakeupOfParent;
  };
  /// The child's end. Throws Error("no-process").
  explicit Channel(Inherited inherited, ChannelLimits limits = {});

  /// The descriptors to pass to the child, from kMemoryOfChild on.
  std::array<int, 3> of_child() const;

  /// Any thread; never waits. Returns false if the message is not sent: it is too large, too much is waiting,
  /// or the channel is broken. `must`: not droppable; only the limit for all waiting messages applies.
  bool send(std::span<const std::byte> message, bool must);
  enum class Received { message, nothing, broken };
  /// One thread: receives the next message. Also sends waiting messages.
  Received receive(std::vector<std::byte>& message);
  /// Same thread. Call it before a sleep on bell(). Returns false if there is already something to receive.
  bool may_sleep();
  /// Same thread. Call it after the sleep.
  void woken();
  int bell() const { return own_wakeup_.number(); }
  /// Sleeps at most `most_ms`; returns at once if there is something to do.
  void wait(int most_ms);

  bool broken() const;
  /// Count of messages that the other side dropped, as it reports.
  std::uint64_t dropped_there() const;
  /// Heartbeat count of the child's main loop; for the parent.
  std::uint64_t beats() const;
  void beat();
  /// Heartbeat count of the child's pulse thread (pulse.hpp); for the parent.
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
  /// Pushes as much as fits. Returns false if there is not enough room; `sent`: bytes pushed so far.
  bool push(std::span<const std::byte> message, std::size_t& sent);
  void flush();

  const ChannelLimits limits_;
  SharedMemory memory_;
  Descriptor own_wakeup_, other_wakeup_;
  const bool parent_;
  RingReader reader_;
  std::vector<std::byte> partial_;

  mutable std::mutex mutex_;  ///< guards the sending side
  RingWriter writer_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0, waiting_droppable_ = 0, first_sent_ = 0;
  bool broken_ = false;
};

}  // namespace polyarm::process
