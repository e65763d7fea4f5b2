#pragma once
/// Time budgets of callbacks on the control thread; times in ns.
#include <cstdint>

#include "polyarm/base/time.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// A callback of the loop that exceeded its time budget.
struct Overrun {
  std::int32_t who = -1;
  const char* callback = "";
  Nanoseconds took = 0, budget = 0;  ///< ns
  std::uint64_t cycle = 0;
};

/// Times callbacks against their budgets on the control thread and reports overruns to one other thread.
/// A call without a budget costs one comparison; a call with a budget costs two clock reads. The queue holds
/// 256 overruns; further ones are dropped until the other thread takes some.
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
  /// The other thread: takes the oldest overrun. Returns false if there is none.
  bool take(Overrun& out) { return queue_.pop(out); }

 private:
  Queue<Overrun> queue_{256};
};

}  // namespace polyarm::realtime
