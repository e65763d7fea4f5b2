#pragma once
/// Exchanges large objects with the real-time thread without allocation on its side.
#include <memory>

#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// Passes large objects (trajectories, models) to the real-time side and takes them back to free them, so
/// that the real-time side neither constructs nor destroys anything. One thread on each side; neither waits.
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

  /// Builder's side: returns false if the other side has not taken the last ones; the caller keeps `item`.
  bool give(std::unique_ptr<T>& item) {
    collect();
    if (!there_.push(item.get())) return false;
    item.release();
    return true;
  }
  /// Builder's side: frees returned items.
  void collect() {
    for (T* item = nullptr; back_.pop(item);) delete item;
  }

  /// Real-time side: the next item, or null. The real-time side owns it until put_back().
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
