#pragma once
/// The newest value from one writer to one real-time reader. The reader never waits: while the writer copies,
/// it keeps its old value.
#include <memory>
#include <mutex>
#include <utility>

#include "polyarm_ros/standard.hpp"

namespace realtime_tools {

template <class T>
class RealtimeBuffer {
 public:
  RealtimeBuffer() = default;
  explicit RealtimeBuffer(const T& value) { initRT(value); }
  RealtimeBuffer(const RealtimeBuffer& other) { *this = other; }
  RealtimeBuffer& operator=(const RealtimeBuffer& other) {
    if (this == &other) return *this;
    const std::lock_guard lock(other.mutex_);
    read_ = other.read_, write_ = other.write_, fresh_ = other.fresh_;
    return *this;
  }

  T* readFromRT() {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && fresh_) {
      std::swap(read_, write_);
      fresh_ = false;
    }
    return &read_;
  }
  const T* readFromRT() const { return const_cast<RealtimeBuffer*>(this)->readFromRT(); }
  T* readFromNonRT() const {
    const std::lock_guard lock(mutex_);
    return const_cast<T*>(fresh_ ? &write_ : &read_);
  }
  void writeFromNonRT(const T& value) {
    const std::lock_guard lock(mutex_);
    write_ = value, fresh_ = true;
  }
  void initRT(const T& value) { read_ = value, write_ = value, fresh_ = false; }
  void reset() { initRT(T{}); }

 private:
  T read_{}, write_{};
  bool fresh_ = false;
  mutable std::mutex mutex_;
};

}  // namespace realtime_tools
