#pragma once
#include "message_filters/sync_policies/exact_time.hpp"

namespace message_filters {
/// Messages with the same stamp. Filters come first, then how many messages of each may wait.
template <typename... Ms>
class TimeSynchronizer : public Synchronizer<sync_policies::ExactTime<Ms...>> {
  using Policy = sync_policies::ExactTime<Ms...>;

 public:
  explicit TimeSynchronizer(std::uint32_t size) : Synchronizer<Policy>(Policy(size)) {}
  template <typename First, typename Second, typename... Rest,
            typename = std::enable_if_t<!std::is_arithmetic_v<First>>>
  TimeSynchronizer(First& first, Second& second, Rest&&... rest) : TimeSynchronizer(size_of(rest...)) {
    connect_front(std::make_index_sequence<sizeof...(Ms)>(), std::tie(first, second, rest...));
  }

 private:
  template <typename... Rest>
  static std::uint32_t size_of(Rest&... rest) {
    return static_cast<std::uint32_t>(std::get<sizeof...(Rest) - 1>(std::tie(rest...)));
  }
  template <std::size_t... I, typename Tuple>
  void connect_front(std::index_sequence<I...>, const Tuple& all) {
    this->connectInput(std::get<I>(all)...);
  }
};
}  // namespace message_filters
