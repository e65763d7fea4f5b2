#pragma once
/// How a component is hosted, and what others may know of it.
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::hardware {

struct HostOptions {
  unsigned divisor = 1;  ///< the component is read and written every so many cycles
  bool async = false;    ///< it runs on a thread of its own
  /// Period of an async component's own clock, ns; any value is allowed, and `divisor` has no effect. 0: the
  /// loop triggers its thread every `divisor` cycles.
  Nanoseconds period = 0;
  bool lock_step = false;  ///< async work is done inline
  realtime::ThreadOptions thread = {};
  WhenLate when_late = WhenLate::report;  ///< for its thread
  unsigned late_after = 10;               ///< runs in a row that were late, or turns that were missed
  Nanoseconds budget = 0;                 ///< for each read and write in the loop, ns; 0: unlimited
  std::string group;                      ///< components of one group fail together
  bool contained = false;                 ///< its fault concerns its group alone, not the whole loop
  std::string plugin, type;               ///< as the description has them, for lists
  LifecycleState initial = LifecycleState::active;  ///< where configure_and_activate() takes it
  /// How far a joint may be from its command for kFollowingTime, rad or m; infinite: unlimited. The parameter
  /// `following_error` of the component; without it kRealFollowingError for real hardware, else infinite.
  double following_error = std::numeric_limits<double>::infinity();
};
inline constexpr double kRealFollowingError = 0.35;
inline constexpr Nanoseconds kFollowingTime = 250'000'000;
/// Between two reads a joint's measured position changes by at most kJumpFactor times what its velocity
/// allows in the longest time that may lie between them, plus kJumpFloor (rad or m) for noise and rounding.
/// That time is the period of the reads; with a thread, from the beginning of the exchange before to the end
/// of this one.
inline constexpr double kJumpFactor = 5, kJumpFloor = 0.02;

/// A component as lists show it.
struct HostedInfo {
  std::string name, plugin, type, group;
  LifecycleState state;
  unsigned divisor;
  bool async;
  Nanoseconds period;  ///< of a component with a clock of its own; else 0
  std::uint64_t missed;
  std::vector<std::string> states, commands;
};

}  // namespace polyarm::hardware
