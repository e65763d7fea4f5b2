#pragma once
/// A component that waits for a device: in its read and write it may wait, lock and write to the system, but
/// neither allocate nor throw.
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "polyarm/hardware/component.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::test {

/// Reads and writes so many cycles under the guard; true when nothing was allocated, freed or thrown.
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
