#pragma once
/// A value behind a lock. The real-time side uses try_get and try_set, which never wait.
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "polyarm_ros/standard.hpp"
#include "realtime_tools/mutex.hpp"

namespace realtime_tools {

template <class T, typename Mutex = prio_inherit_mutex>
class RealtimeThreadSafeBox {
 public:
  using mutex_t = Mutex;
  using type = T;
  explicit RealtimeThreadSafeBox(const T& value = T{}) : value_(value) {}
  void set(const T& value) {
    const std::lock_guard<Mutex> lock(mutex_);
    value_ = value;
  }
  bool try_set(const T& value) {
    std::unique_lock<Mutex> lock(mutex_, std::try_to_lock);
    if (lock.owns_lock()) value_ = value;
    return lock.owns_lock();
  }
  bool trySet(const T& value) { return try_set(value); }
  template <typename Call, typename = std::enable_if_t<std::is_invocable_v<Call, T&>>>
  void set(Call&& call) {
    const std::lock_guard<Mutex> lock(mutex_);
    call(value_);
  }
  template <typename Call, typename = std::enable_if_t<std::is_invocable_v<Call, T&>>>
  bool try_set(Call&& call) {
    std::unique_lock<Mutex> lock(mutex_, std::try_to_lock);
    if (lock.owns_lock()) call(value_);
    return lock.owns_lock();
  }
  T get() const {
    const std::lock_guard<Mutex> lock(mutex_);
    return value_;
  }
  void get(T& out) const { out = get(); }
  template <typename Call, typename = std::enable_if_t<std::is_invocable_v<Call, const T&>>>
  void get(Call&& call) const {
    const std::lock_guard<Mutex> lock(mutex_);
    call(value_);
  }
  std::optional<T> try_get() const {
    std::unique_lock<Mutex> lock(mutex_, std::try_to_lock);
    return lock.owns_lock() ? std::optional<T>(value_) : std::nullopt;
  }
  std::optional<T> tryGet() const { return try_get(); }
  template <typename Call, typename = std::enable_if_t<std::is_invocable_v<Call, const T&>>>
  bool try_get(Call&& call) const {
    std::unique_lock<Mutex> lock(mutex_, std::try_to_lock);
    if (lock.owns_lock()) call(value_);
    return lock.owns_lock();
  }
  const Mutex& get_mutex() const { return mutex_; }
  Mutex& get_mutex() { return mutex_; }

 private:
  T value_;
  mutable Mutex mutex_;
};
template <class T>
using RealtimeBox = RealtimeThreadSafeBox<T>;
template <class T>
using RealtimeBoxBestEffort = RealtimeThreadSafeBox<T>;

}  // namespace realtime_tools
