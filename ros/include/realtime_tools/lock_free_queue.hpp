#pragma once
/// A bounded queue. push and pop never wait: they fail when the queue is full, empty or in use.
#include <cstddef>
#include <deque>
#include <mutex>
#include <vector>

#include "polyarm_ros/standard.hpp"

namespace realtime_tools {

template <typename T, std::size_t Capacity = 0>
class LockFreeSPSCQueue {
 public:
  LockFreeSPSCQueue() : LockFreeSPSCQueue(Capacity) {}
  explicit LockFreeSPSCQueue(std::size_t capacity) : places_(capacity + 1) {}
  bool push(const T& value) {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || (head_ + 1) % places_.size() == tail_) return false;
    places_[head_] = value, head_ = (head_ + 1) % places_.size();
    return true;
  }
  bool bounded_push(const T& value) { return push(value); }
  bool pop(T& out) {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || head_ == tail_) return false;
    out = places_[tail_], tail_ = (tail_ + 1) % places_.size();
    return true;
  }
  bool get_latest(T& out) {
    bool any = false;
    while (pop(out)) any = true;
    return any;
  }
  bool empty() const { return size() == 0; }
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return (head_ + places_.size() - tail_) % places_.size();
  }
  std::size_t capacity() const { return places_.size() - 1; }

 private:
  mutable std::mutex mutex_;
  std::vector<T> places_;
  std::size_t head_ = 0, tail_ = 0;
};
template <typename T, std::size_t Capacity = 0>
using LockFreeMPMCQueue = LockFreeSPSCQueue<T, Capacity>;

}  // namespace realtime_tools
