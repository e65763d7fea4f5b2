#include "polyarm/process/channel.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::process {

namespace {
constexpr std::size_t kRing = std::size_t{1} << 20, kHeadOfMemory = 4096;
constexpr std::size_t kMemory = kHeadOfMemory + 2 * kRing;

[[noreturn]] void refuse(const char* what) {
  throw Error("no-process", std::string(what) + ": " + std::strerror(errno),
              "look at the limits of open files and memory (ulimit -a)");
}
}  // namespace

SharedMemory::SharedMemory(std::size_t size)
    : descriptor_{::memfd_create("polyarm", MFD_CLOEXEC | MFD_ALLOW_SEALING)} {
  // Sealed, because a process that shrinks it could crash the other side.
  if (descriptor_.number() < 0 || ::ftruncate(descriptor_.number(), static_cast<off_t>(size)) != 0 ||
      ::fcntl(descriptor_.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    refuse("no memory can be shared with another process");
  map(size);
}

SharedMemory::SharedMemory(Descriptor descriptor, std::size_t size) : descriptor_{std::move(descriptor)} {
  struct stat seen {};
  if (::fstat(descriptor_.number(), &seen) != 0 || seen.st_size != static_cast<off_t>(size))
    refuse("the memory of another process does not exist");
  map(size);
}

void SharedMemory::map(std::size_t size) {
  void* const at = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_.number(), 0);
  if (at == MAP_FAILED) refuse("memory of another process cannot be mapped");
  bytes_ = {static_cast<std::byte*>(at), size};
}

SharedMemory::~SharedMemory() {
  ::munmap(bytes_.data(), bytes_.size());
}

/// At the start of the memory. All zeros is its initial state.
struct Channel::Shared {
  RingState to_child, to_parent;
  std::atomic<std::uint64_t> beats, pulses, dropped_by_child, dropped_by_parent;
};

Channel::Shared& Channel::shared() const {
  static_assert(sizeof(Shared) <= kHeadOfMemory);
  return *std::launder(reinterpret_cast<Shared*>(memory_.bytes().data()));
}
std::span<std::byte> Channel::ring_bytes(int index) const {
  return memory_.bytes().subspan(kHeadOfMemory + static_cast<std::size_t>(index) * kRing, kRing);
}

Channel::Channel(ChannelLimits limits)
    : limits_{limits},
      memory_{kMemory},
      own_wakeup_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)},
      other_wakeup_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)},
      parent_{true},
      reader_{shared().to_parent, ring_bytes(1)},
      writer_{shared().to_child, ring_bytes(0)} {
  if (own_wakeup_.number() < 0 || other_wakeup_.number() < 0) refuse("no bell between two processes can be made");
}

Channel::Channel(Inherited inherited, ChannelLimits limits)
    : limits_{limits},
      memory_{Descriptor(inherited.memory), kMemory},
      own_wakeup_{inherited.own_wakeup},
      other_wakeup_{inherited.other_wakeup},
      parent_{false},
      reader_{shared().to_child, ring_bytes(0)},
      writer_{shared().to_parent, ring_bytes(1)} {}

std::array<int, 3> Channel::of_child() const {
  return {memory_.descriptor(), other_wakeup_.number(), own_wakeup_.number()};
}

/// A bell with a full counter is already ringing.
void Channel::ring_other() const {
  const std::uint64_t once = 1;
  if (::write(other_wakeup_.number(), &once, sizeof once) < 0) errno = 0;
}

bool Channel::push(std::span<const std::byte> message, std::size_t& sent) {
  RingState& state = parent_ ? shared().to_child : shared().to_parent;
  bool more = true, put = false, asked = false;
  while (more && !broken_) {
    const std::size_t now = std::min(kMostInFrame, message.size() - sent);
    const bool last = sent + now == message.size();
    const RingResult result = writer_.put(message.subspan(sent, now), last);
    if (result == RingResult::broken) broken_ = true;
    if (result == RingResult::done) {
      put = true;
      sent += now;
      more = !last;
    } else if (result == RingResult::none) {
      if (std::exchange(asked, true)) break;
      state.full.store(1);  // the writer tries once more, because there may be room by now
      std::atomic_thread_fence(std::memory_order_seq_cst);
    }
  }
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (put && state.asleep.load(std::memory_order_relaxed) != 0 && state.asleep.exchange(0) != 0) ring_other();
  return !more;
}

bool Channel::send(std::span<const std::byte> message, bool must) {
  const std::lock_guard lock(mutex_);
  if (broken_ || message.size() > limits_.most_message) return false;
  std::size_t sent = 0;
  if (waiting_.empty() && push(message, sent)) return true;
  if (broken_) return false;
  // A message that has been started must be finished.
  if (!must && sent == 0 &&
      (waiting_bytes_ + message.size() > limits_.most_waiting ||
       waiting_droppable_ >= limits_.most_messages)) {
    (parent_ ? shared().dropped_by_parent : shared().dropped_by_child)
        .fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (waiting_bytes_ + message.size() > limits_.most_ever) {
    broken_ = true;
    return false;
  }
  if (waiting_.empty()) first_sent_ = sent;
  waiting_.push_back({{message.begin(), message.end()}, must});
  waiting_bytes_ += message.size();
  waiting_droppable_ += must ? 0 : 1;
  return true;
}

void Channel::flush() {
  const std::lock_guard lock(mutex_);
  while (!waiting_.empty() && !broken_ && push(waiting_.front().message, first_sent_)) {
    waiting_bytes_ -= waiting_.front().message.size();
    waiting_droppable_ -= waiting_.front().must ? 0 : 1;
    waiting_.pop_front();
    first_sent_ = 0;
  }
}

Channel::Received Channel::receive(std::vector<std::byte>& message) {
  flush();
  RingState& state = parent_ ? shared().to_parent : shared().to_child;
  for (bool last = false;;) {
    const RingResult result = reader_.take(partial_, limits_.most_message, last);
    if (result == RingResult::broken) {
      const std::lock_guard lock(mutex_);
      broken_ = true;
    }
    if (result == RingResult::broken) return Received::broken;
    std::atomic_thread_fence(std::memory_order_seq_cst);
    if (state.full.load(std::memory_order_relaxed) != 0 && reader_.half_empty() &&
        state.full.exchange(0) != 0)
      ring_other();
    if (result == RingResult::none) return Received::nothing;
    if (!last) continue;
    message.swap(partial_);
    partial_.clear();
    return Received::message;
  }
}

bool Channel::may_sleep() {
  RingState& state = parent_ ? shared().to_parent : shared().to_child;
  state.asleep.store(1);
  std::atomic_thread_fence(std::memory_order_seq_cst);
  return !reader_.something();
}

void Channel::woken() {
  (parent_ ? shared().to_parent : shared().to_child).asleep.store(0, std::memory_order_relaxed);
  std::uint64_t times = 0;
  if (::read(own_wakeup_.number(), &times, sizeof times) < 0) errno = 0;
}

void Channel::wait(int most_ms) {
  pollfd bell{own_wakeup_.number(), POLLIN, 0};
  if (may_sleep() && ::poll(&bell, 1, most_ms) < 0) errno = 0;
  woken();
}

bool Channel::broken() const {
  const std::lock_guard lock(mutex_);
  return broken_;
}
std::uint64_t Channel::dropped_there() const {
  return (parent_ ? shared().dropped_by_child : shared().dropped_by_parent).load(std::memory_order_relaxed);
}
std::uint64_t Channel::beats() const {
  return shared().beats.load(std::memory_order_relaxed);
}
void Channel::beat() {
  shared().beats.fetch_add(1, std::memory_order_relaxed);
}
std::uint64_t Channel::pulses() const {
  return shared().pulses.load(std::memory_order_relaxed);
}
void Channel::pulse() {
  shared().pulses.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace polyarm::process
