#pragma once
/// Options for hosting a component, and its facts for lists.
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::hardware {

struct HostOptions {
  unsigned divisor = 1;  ///< read and written every `divisor` cycles
  bool async = false;    ///< runs on a thread of its own
  /// Period of an async component's own clock, ns; any value is allowed, and `divisor` has no effect. 0: the
  /// loop triggers its thread every `divisor` cycles.
  Nanoseconds period = 0;
  bool lock_step = false;  ///< async work is done inline
  realtime::ThreadOptions thread = {};
  WhenLate when_late = WhenLate::report;  ///< for its thread
  unsigned late_after = 10;               ///< number of late runs in a row, or missed turns
  Nanoseconds budget = 0;                 ///< limit for each read and write in the loop, ns; 0: unlimited
  std::string group;                      ///< components of one group fail together
  bool contained = false;                 ///< its faults affect its group only, not the whole loop
  std::string plugin, type;               ///< from the description, for lists
  LifecycleState initial = LifecycleState::active;  ///< state after configure_and_activate()
  /// Allowed distance of a joint from its command, for kFollowingTime, rad or m; infinite: unlimited. Set by
  /// the component's parameter `following_error`; default: kRealFollowingError for real hardware, otherwise
  /// infinite.
  double following_error = std::numeric_limits<double>::infinity();
};
inline constexpr double kRealFollowingError = 0.35;
inline constexpr Nanoseconds kFollowingTime = 250'000'000;
/// Between two reads a joint's measured position may change by kJumpFactor times the distance that its
/// velocity limit allows in the longest possible time between them, plus kJumpFloor (rad or m) for noise and
/// rounding. That time is the period of the reads; with a thread, from the start of the previous exchange to
/// the end of this one.
inline constexpr double kJumpFactor = 5, kJumpFloor = 0.02;

/// Facts about a component, for lists.
struct HostedInfo {
  std::string name, plugin, type, group;
  LifecycleState state;
  unsigned divisor;
  bool async;
  Nanoseconds period;  ///< for a component with its own clock; otherwise 0
  std::uint64_t missed;
  std::vector<std::string> states, commands;
};

}  // namespace polyarm::hardware
