#pragma once
/// Joint positions of a controller that answers requests more slowly than the loop runs. Radians. Control
/// thread; nothing waits, locks or allocates.
#include <algorithm>

#include "drivers/wire/shaper.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::forward {

using wire::Six;

/// Goes straight from reading to reading, so it is one reading late. After 0.5 s without a reading, or when
/// the count begins anew, it jumps to the next one.
class Readings {
 public:
  /// `q`: of the newest reading; `count`: of readings, from 1.
  const Six& at(const Six& q, std::uint64_t count, const hardware::Cycle& cycle) noexcept {
    constexpr Nanoseconds kLongest = 500'000'000;
    if (count != count_) {
      const bool first = count_ == 0 || count < count_ || cycle.time - at_ > kLongest;
      from_ = first ? q : q_;
      span_ = first ? 0 : cycle.time - at_;
      at_ = cycle.time;
      count_ = count;
    }
    const double share = span_ <= cycle.period
                             ? 1
                             : std::min(1.0, static_cast<double>(cycle.time - at_ + cycle.period) /
                                                 static_cast<double>(span_));
    for (std::size_t j = 0; j < 6; ++j) q_[j] = from_[j] + share * (q[j] - from_[j]);
    return q_;
  }
  /// What at() returned last.
  const Six& shown() const noexcept { return q_; }

 private:
  Six from_{}, q_{};
  std::uint64_t count_ = 0;
  Nanoseconds at_ = 0, span_ = 0;
};

}  // namespace polyarm::forward
