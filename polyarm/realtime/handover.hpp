#pragma once
#include <memory>

#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// Hands large things (trajectories, models) to the real-time side and takes them back to be freed, so that
/// the real-time side neither builds nor destroys anything. One thread on each side; neither ever waits.
template <typename T>
class Handover {
 public:
  explicit Handover(std::size_t capacity = 16) : there_(capacity), back_(2 * capacity + 2) {}
  ~Handover() {
    for (T* item = nullptr; there_.pop(item);) delete item;
    collect();
  }
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;

  /// Builder's side: false when the other side has not taken the last ones yet; `item` stays with the caller.
  bool give(std::unique_ptr<T>& item) {
    collect();
    if (!there_.push(item.get())) return false;
    item.release();
    return true;
  }
  /// Builder's side: frees what came back.
  void collect() {
    for (T* item = nullptr; back_.pop(item);) delete item;
  }

  /// Real-time side: the next item, or null. It is owned by the taker until put_back.
  T* take() noexcept {
    T* item = nullptr;
    return there_.pop(item) ? item : nullptr;
  }
  void put_back(T* item) noexcept {
    if (item) back_.push(item);
  }

 private:
  Queue<T*> there_, back_;
};

}  // namespace polyarm::realtime
