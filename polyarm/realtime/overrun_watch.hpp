#pragma once
#include <cstdint>

#include "polyarm/base/time.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// A callback of the loop that took longer than it may.
struct Overrun {
  std::int32_t who = -1;
  const char* callback = "";
  Nanoseconds took = 0, budget = 0;  ///< ns
  std::uint64_t cycle = 0;
};

/// Times callbacks against their budgets on the control thread, and tells one other thread which overran.
/// Without a budget that costs one comparison, with one two looks at the clock. Of
/// overruns that nobody takes only the first 256 are kept.
class OverrunWatch {
 public:
  template <typename Call>
  auto timed(Nanoseconds budget, std::int32_t who, const char* callback, std::uint64_t cycle,
             Call call) noexcept {
    if (budget <= 0) return call();
    const Nanoseconds before = monotonic_now();
    const auto result = call();
    const Nanoseconds took = monotonic_now() - before;
    if (took > budget) queue_.push(Overrun{who, callback, took, budget, cycle});
    return result;
  }
  /// The other thread.
  bool take(Overrun& out) { return queue_.pop(out); }

 private:
  Queue<Overrun> queue_{256};
};

}  // namespace polyarm::realtime
