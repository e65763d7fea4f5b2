#pragma once
#include <limits>

#include "message_filters/synchronizer.hpp"
#include "rclcpp/duration.hpp"

namespace message_filters::sync_policies {
/// Each message is in at most one set. When each input has one, the latest of their oldest is the pivot, and
/// of each other input the message that is closest to it belongs to the set. The set is complete when no
/// later message of an input can be closer: one at or after the pivot has come, or it stands within the lower
/// bound between two messages.
template <typename... Ms>
class ApproximateTime : public PolicyBase<Ms...> {
  using Base = PolicyBase<Ms...>;

 public:
  explicit ApproximateTime(std::uint32_t size) : Base(size), asked_(size) {}
  ApproximateTime like() const {
    ApproximateTime out(asked_);
    out.longest_ = longest_;
    out.apart_ = apart_;
    return out;
  }
  void setAgePenalty(double) {}
  void setInterMessageLowerBound(std::size_t input, const rclcpp::Duration& bound) {
    apart_.at(input) = bound.nanoseconds();
  }
  void setInterMessageLowerBound(const rclcpp::Duration& bound) { apart_.fill(bound.nanoseconds()); }
  void setMaxIntervalDuration(const rclcpp::Duration& span) { longest_ = span.nanoseconds(); }

 protected:
  template <std::size_t I>
  void take_in(const std::shared_ptr<const std::tuple_element_t<I, typename Base::Messages>>& message) {
    std::unique_lock lock(*this->mutex_);
    this->template put<I>(message);
    std::vector<typename Base::Set> sets;
    std::array<std::size_t, Base::kInputs> at{};
    while (find(at)) sets.push_back(this->take(at));
    this->call(lock, sets);
  }

 private:
  /// True if a set is complete.
  bool find(std::array<std::size_t, Base::kInputs>& at) {
    for (;;) {
      std::int64_t pivot = std::numeric_limits<std::int64_t>::min();
      for (const auto& all : this->stamps_) {
        if (all.empty()) return false;
        pivot = std::max(pivot, all.front());
      }
      std::int64_t first = std::numeric_limits<std::int64_t>::max(), last = pivot;
      std::size_t oldest = 0;
      for (std::size_t i = 0; i < Base::kInputs; ++i) {
        const auto& all = this->stamps_[i];
        std::size_t best = 0;
        while (best + 1 < all.size() && std::abs(all[best + 1] - pivot) <= std::abs(all[best] - pivot))
          ++best;
        const bool may_be_closer =
            all[best] < pivot && best + 1 == all.size() && all[best] + apart_[i] - pivot < pivot - all[best];
        if (may_be_closer) return false;
        at[i] = best;
        if (all[best] < first) first = all[best], oldest = i;
        last = std::max(last, all[best]);
      }
      if (last - first <= longest_) return true;
      for (std::size_t n = 0; n <= at[oldest]; ++n)
        this->drop(oldest);  // too far apart: it belongs to no set
    }
  }
  std::uint32_t asked_;
  std::int64_t longest_ = std::numeric_limits<std::int64_t>::max();
  std::array<std::int64_t, Base::kInputs> apart_{};
};
}  // namespace message_filters::sync_policies
