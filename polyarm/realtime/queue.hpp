#pragma once
/// Lock-free queue of fixed capacity between two threads.
#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace polyarm::realtime {

/// First-in, first-out queue from one writer thread to one reader thread. Neither thread waits. Space for
/// `capacity` values is allocated up front. If the queue is full, push() returns false and the caller keeps
/// the value. It suits queues that are nearly always empty and checked in every cycle: a check reads one cache
/// line, which the two threads share.
template <typename T>
class alignas(64) Queue {
 public:
  explicit Queue(std::size_t capacity) : slots_(capacity + 1) {}

  bool push(T&& value) noexcept {
    const std::size_t at = tail_.load(std::memory_order_relaxed);
    const std::size_t next = at + 1 == slots_.size() ? 0 : at + 1;
    if (next == head_.load(std::memory_order_acquire)) return false;
    slots_[at] = std::move(value);
    tail_.store(next, std::memory_order_release);
    return true;
  }
  bool push(const T& value) noexcept {
    T copy = value;
    return push(std::move(copy));
  }

  bool pop(T& value) noexcept {
    const std::size_t at = head_.load(std::memory_order_relaxed);
    if (at == tail_.load(std::memory_order_acquire)) return false;
    value = std::move(slots_[at]);
    head_.store(at + 1 == slots_.size() ? 0 : at + 1, std::memory_order_release);
    return true;
  }

  bool empty() const noexcept {
    return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_acquire);
  }

 private:
  std::vector<T> slots_;
  std::atomic<std::size_t> head_{0}, tail_{0};
};

}  // namespace polyarm::realtime
