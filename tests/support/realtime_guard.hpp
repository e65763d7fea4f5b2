#pragma once
#include <cstdint>
#include <string>

namespace polyarm::test {

/// While one of these lives, the calling thread may not allocate, free, lock, wait, write or throw; what it
/// does all the same is counted, not prevented. Link tests/support/realtime_guard.cpp into the program: it
/// stands in front of the C library's functions. Sanitizers bring their own, so there the guard watches
/// nothing (see watches()).
class RealtimeGuard {
 public:
  RealtimeGuard();
  ~RealtimeGuard();
  static bool watches();
  /// What has been done since construction, "" if nothing: "malloc x3, pthread_mutex_lock x1".
  std::string violations() const;
};

}  // namespace polyarm::test
