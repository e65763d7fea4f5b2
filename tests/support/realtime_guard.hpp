#pragma once
/// Counts what a thread must not do in the control cycle.
#include <cstdint>
#include <string>

namespace polyarm::test {

/// While a guard exists, the calling thread may not allocate, free, lock, wait, write or throw. Violations
/// are counted, not prevented. Link tests/support/realtime_guard.cpp into the program: it replaces functions
/// of the C library. Sanitizers replace the same functions, so with them the guard watches nothing (see
/// watches()).
class RealtimeGuard {
 public:
  RealtimeGuard();
  ~RealtimeGuard();
  static bool watches();
  /// The violations since construction: "malloc x3, pthread_mutex_lock x1"; "" if there are none.
  std::string violations() const;
  /// How often memory was allocated since construction.
  static std::uint64_t allocations();
};

}  // namespace polyarm::test
