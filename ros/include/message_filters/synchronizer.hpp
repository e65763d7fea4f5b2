#pragma once
/// Messages of two to nine inputs that belong together. A policy decides (sync_policies/): it has queues of
/// the messages that wait, and hands sets to the synchronizer's callbacks, in the thread that brought the
/// last message.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "message_filters/message_traits.hpp"
#include "message_filters/null_types.hpp"
#include "message_filters/simple_filter.hpp"

namespace message_filters {

/// Queues of the messages of each input, at most `size` each, and the callbacks. For policies.
template <typename... Ms>
class PolicyBase {
 public:
  static constexpr std::size_t kInputs = sizeof...(Ms);
  using Messages = std::tuple<Ms...>;
  using Events = std::tuple<MessageEvent<const Ms>...>;
  using Callback = std::function<void(const std::shared_ptr<const Ms>&...)>;

  explicit PolicyBase(std::uint32_t size) : size_(size ? size : 1) {}
  template <typename Call>
  Connection registerCallback(const Call& call) {
    const auto made = [&] {
      if constexpr (std::is_invocable_v<const Call&, const std::shared_ptr<const Ms>&...>)
        return std::make_shared<Callback>(call);
      else
        return std::make_shared<Callback>(
            [call](const std::shared_ptr<const Ms>&... m) { call(MessageEvent<const Ms>(m)...); });
    }();
    const std::lock_guard lock(*mutex_);
    callbacks_->push_back(made);
    return Connection([all = std::weak_ptr<All>(callbacks_), mutex = mutex_, made] {
      const std::lock_guard guard(*mutex);
      if (const auto here = all.lock())
        here->erase(std::remove(here->begin(), here->end(), made), here->end());
    });
  }

 protected:
  using All = std::vector<std::shared_ptr<Callback>>;
  template <std::size_t I>
  std::deque<std::shared_ptr<const std::tuple_element_t<I, Messages>>>& queue() {
    return std::get<I>(queues_);
  }
  std::array<std::deque<std::int64_t>, kInputs> stamps_;  ///< of the messages in the queues, ns
  template <std::size_t I>
  void put(const std::shared_ptr<const std::tuple_element_t<I, Messages>>& message) {
    const auto stamp =
        message_traits::TimeStamp<std::tuple_element_t<I, Messages>>::value(*message).nanoseconds();
    if (stamps_[I].size() >= size_) drop(I);
    auto at = stamps_[I].size();
    while (at > 0 && stamps_[I][at - 1] > stamp) --at;  // one that comes late
    stamps_[I].insert(stamps_[I].begin() + static_cast<std::ptrdiff_t>(at), stamp);
    queue<I>().insert(queue<I>().begin() + static_cast<std::ptrdiff_t>(at), message);
  }
  /// Forgets the oldest message of an input.
  void drop(std::size_t input) { drop_one(input, std::make_index_sequence<kInputs>()); }
  /// The set of the message at `at[i]` of each input; it and what is older leave the queues.
  auto take(const std::array<std::size_t, kInputs>& at) {
    return take_all(at, std::make_index_sequence<kInputs>());
  }
  using Set = std::tuple<std::shared_ptr<const Ms>...>;
  void call(std::unique_lock<std::mutex>& lock, const std::vector<Set>& sets) {
    const All all = *callbacks_;
    lock.unlock();
    for (const Set& set : sets)
      for (const auto& each : all) std::apply(*each, set);
  }
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();

 private:
  template <std::size_t... I>
  void drop_one(std::size_t input, std::index_sequence<I...>) {
    (void)((I == input ? (queue<I>().pop_front(), stamps_[I].pop_front(), true) : false) || ...);
  }
  template <std::size_t... I>
  Set take_all(const std::array<std::size_t, kInputs>& at, std::index_sequence<I...>) {
    Set out{queue<I>()[at[I]]...};
    for (std::size_t i = 0; i < kInputs; ++i)
      for (std::size_t n = 0; n <= at[i]; ++n) drop(i);
    return out;
  }
  const std::uint32_t size_;
  std::tuple<std::deque<std::shared_ptr<const Ms>>...> queues_;
  std::shared_ptr<All> callbacks_ = std::make_shared<All>();
};

template <typename Policy>
class Synchronizer : public Policy {
 public:
  using Messages = typename Policy::Messages;
  using Events = typename Policy::Events;

  template <typename... Filters, typename = std::enable_if_t<sizeof...(Filters) == Policy::kInputs>>
  explicit Synchronizer(Filters&... filters) : Policy(10) {
    connectInput(filters...);
  }
  template <typename... Filters, typename = std::enable_if_t<sizeof...(Filters) == Policy::kInputs>>
  explicit Synchronizer(const Policy& policy, Filters&... filters) : Policy(policy.like()) {
    connectInput(filters...);
  }
  explicit Synchronizer(const Policy& policy) : Policy(policy.like()) {}
  Synchronizer() : Policy(10) {}
  ~Synchronizer() {
    for (Connection& each : inputs_) each.disconnect();
  }

  template <typename... Filters>
  void connectInput(Filters&... filters) {
    static_assert(sizeof...(Filters) == Policy::kInputs, "an input for each message of the policy");
    for (Connection& each : inputs_) each.disconnect();
    inputs_.clear();
    connect(std::index_sequence_for<Filters...>(), filters...);
  }
  template <typename Call>
  Connection registerCallback(const Call& call) {
    return Policy::registerCallback(call);
  }
  template <typename Call, typename T>
  Connection registerCallback(Call T::*call, T* of) {
    return Policy::registerCallback([call, of](const auto&... m) { (of->*call)(m...); });
  }
  template <std::size_t I>
  void add(const std::shared_ptr<const std::tuple_element_t<I, Messages>>& message) {
    Policy::template take_in<I>(message);
  }
  void setName(const std::string& name) { name_ = name; }
  const std::string& getName() const { return name_; }
  Policy* getPolicy() { return this; }

 private:
  template <std::size_t... I, typename... Filters>
  void connect(std::index_sequence<I...>, Filters&... filters) {
    (inputs_.push_back(
         filters.registerCallback([this](const std::shared_ptr<const std::tuple_element_t<I, Messages>>& m) {
           this->template add<I>(m);
         })),
     ...);
  }
  std::vector<Connection> inputs_;
  std::string name_;
};

}  // namespace message_filters
