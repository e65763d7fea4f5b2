#pragma once
#include "message_filters/synchronizer.hpp"

namespace message_filters::sync_policies {
/// Messages with the same stamp. What is older than a set is dropped.
template <typename... Ms>
class ExactTime : public PolicyBase<Ms...> {
  using Base = PolicyBase<Ms...>;

 public:
  explicit ExactTime(std::uint32_t size) : Base(size), asked_(size) {}
  ExactTime like() const { return ExactTime(asked_); }

 protected:
  template <std::size_t I>
  void take_in(const std::shared_ptr<const std::tuple_element_t<I, typename Base::Messages>>& message) {
    std::unique_lock lock(*this->mutex_);
    this->template put<I>(message);
    std::vector<typename Base::Set> sets;
    const std::int64_t stamp =
        message_traits::TimeStamp<std::tuple_element_t<I, typename Base::Messages>>::value(*message)
            .nanoseconds();
    std::array<std::size_t, Base::kInputs> at{};
    for (std::size_t i = 0; i < Base::kInputs; ++i) {
      const auto& all = this->stamps_[i];
      const auto found = std::find(all.begin(), all.end(), stamp);
      if (found == all.end()) return;
      at[i] = static_cast<std::size_t>(found - all.begin());
    }
    sets.push_back(this->take(at));
    this->call(lock, sets);
  }

 private:
  std::uint32_t asked_;
};
}  // namespace message_filters::sync_policies
