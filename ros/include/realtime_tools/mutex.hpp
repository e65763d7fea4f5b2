#pragma once
/// Mutexes with priority inheritance.
#include <pthread.h>

#include <system_error>

#include "polyarm_ros/standard.hpp"

namespace realtime_tools {
namespace detail {
template <int kind>
class PriorityMutex {
 public:
  using native_handle_type = pthread_mutex_t*;
  PriorityMutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_settype(&attributes, kind);
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    const int failed = pthread_mutex_init(&mutex_, &attributes);
    pthread_mutexattr_destroy(&attributes);
    if (failed) throw std::system_error(failed, std::system_category(), "no mutex");
  }
  ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityMutex(const PriorityMutex&) = delete;
  PriorityMutex& operator=(const PriorityMutex&) = delete;
  void lock() {
    if (const int failed = pthread_mutex_lock(&mutex_))
      throw std::system_error(failed, std::system_category(), "lock");
  }
  bool try_lock() noexcept { return pthread_mutex_trylock(&mutex_) == 0; }
  void unlock() noexcept { pthread_mutex_unlock(&mutex_); }
  native_handle_type native_handle() noexcept { return &mutex_; }

 private:
  pthread_mutex_t mutex_;
};
}  // namespace detail
using prio_inherit_mutex = detail::PriorityMutex<PTHREAD_MUTEX_ERRORCHECK>;
using prio_inherit_recursive_mutex = detail::PriorityMutex<PTHREAD_MUTEX_RECURSIVE>;
}  // namespace realtime_tools
