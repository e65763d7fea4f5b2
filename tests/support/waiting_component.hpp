#pragma once
/// Checks components that wait for a device. Their read and write may wait, lock and write to the system, but
/// must not allocate or throw.
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "polyarm/hardware/component.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::test {

/// Reads and writes for this many cycles under the guard. Succeeds if nothing was allocated, freed or thrown.
inline ::testing::AssertionResult neither_allocates_nor_throws(hardware::Component& component, int cycles,
                                                               std::span<double> states,
                                                               std::span<const double> commands) {
  std::string violations;
  hardware::Cycle cycle{0, 10'000'000, 0};
  {
    const RealtimeGuard guard;
    for (; cycle.index < static_cast<std::uint64_t>(cycles); ++cycle.index, cycle.time += cycle.period) {
      component.read(cycle, states);
      component.write(cycle, commands);
    }
    violations = guard.violations();
  }
  for (const char* forbidden : {"alloc", "free", "throw"})
    if (violations.find(forbidden) != std::string::npos) return ::testing::AssertionFailure() << violations;
  return ::testing::AssertionSuccess();
}

}  // namespace polyarm::test
