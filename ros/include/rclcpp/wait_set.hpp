#pragma once
/// Waits for messages of subscriptions, for timers, guard conditions, responses of clients and requests of
/// services, without an executor. It takes nothing but the triggers of guard conditions: the caller takes
/// what is ready, or lets an executor run. Any thread.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm_ros/wires.hpp"
#include "rclcpp/client.hpp"
#include "rclcpp/guard_condition.hpp"
#include "rclcpp/service.hpp"
#include "rclcpp/subscription.hpp"
#include "rclcpp/timer.hpp"
#include "rclcpp/utilities.hpp"
#include "rclcpp/wait_result.hpp"

/// What was ready at the last wait, in the order in which it was added: null where nothing was.
struct rcl_wait_set_t {
  std::vector<const void*> subscriptions, guard_conditions, timers, clients, services;
  std::size_t size_of_subscriptions = 0, size_of_guard_conditions = 0, size_of_timers = 0,
              size_of_clients = 0, size_of_services = 0;
};

namespace rclcpp {

struct SubscriptionWaitSetMask {
  bool include_subscription = true, include_events = true, include_intra_process_waitable = true;
};

}  // namespace rclcpp

namespace polyarm_ros {

/// The parts of a wait set that are of one kind. The wait set locks.
template <typename T>
class WaitedFor {
 public:
  explicit WaitedFor(const char* kind) : kind_(kind) {}
  void add(std::shared_ptr<T> one) {
    if (!one) throw std::invalid_argument(std::string(kind_) + " is nullptr");
    if (find(one) != all_.end())
      throw std::runtime_error(std::string(kind_) + " already in use by the wait set");
    all_.push_back(std::move(one));
  }
  void remove(const std::shared_ptr<T>& one) {
    const auto found = find(one);
    if (found == all_.end()) throw std::runtime_error(std::string(kind_) + " not in wait set");
    all_.erase(found);
  }
  /// Notes which are ready now; true if one is.
  template <typename IsReady>
  bool look(const IsReady& is_ready) {
    ready_.assign(all_.size(), nullptr);
    bool any = false;
    for (std::size_t i = 0; i < all_.size(); ++i)
      if (is_ready(*all_[i])) ready_[i] = all_[i], any = true;
    at_ = 0;
    return any;
  }
  std::shared_ptr<T> next_ready() {
    while (at_ < ready_.size())
      if (auto& one = ready_[at_++]) return one;
    return nullptr;
  }
  void list(std::vector<const void*>& out, std::size_t& size) const {
    out.clear();
    for (const auto& one : ready_) out.push_back(one.get());
    size = out.size();
  }
  bool empty() const { return all_.empty(); }

 private:
  auto find(const std::shared_ptr<T>& one) { return std::find(all_.begin(), all_.end(), one); }
  const char* kind_;
  std::vector<std::shared_ptr<T>> all_, ready_;
  std::size_t at_ = 0;
};

}  // namespace polyarm_ros

namespace rclcpp {

class WaitSet {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(WaitSet)
  struct SubscriptionEntry {
    SubscriptionBase::SharedPtr subscription;
    SubscriptionWaitSetMask mask;
    SubscriptionEntry(SubscriptionBase::SharedPtr of = nullptr, SubscriptionWaitSetMask which = {})
        : subscription(std::move(of)), mask(which) {}
  };
  WaitSet() = default;
  explicit WaitSet(const std::vector<SubscriptionEntry>& subscriptions,
                   const std::vector<GuardCondition::SharedPtr>& conditions = {},
                   const std::vector<TimerBase::SharedPtr>& timers = {},
                   const std::vector<ClientBase::SharedPtr>& clients = {},
                   const std::vector<ServiceBase::SharedPtr>& services = {}) {
    add_all(subscriptions, conditions, timers, clients, services);
  }
  WaitSet(const WaitSet&) = delete;
  WaitSet& operator=(const WaitSet&) = delete;

  void add_subscription(SubscriptionBase::SharedPtr one, SubscriptionWaitSetMask = {}) {
    add(subscriptions_, std::move(one));
  }
  void remove_subscription(const SubscriptionBase::SharedPtr& one, SubscriptionWaitSetMask = {}) {
    remove(subscriptions_, one);
  }
  void add_guard_condition(GuardCondition::SharedPtr one) { add(conditions_, std::move(one)); }
  void remove_guard_condition(const GuardCondition::SharedPtr& one) { remove(conditions_, one); }
  void add_timer(TimerBase::SharedPtr one) { add(timers_, std::move(one)); }
  void remove_timer(const TimerBase::SharedPtr& one) { remove(timers_, one); }
  void add_client(ClientBase::SharedPtr one) { add(clients_, std::move(one)); }
  void remove_client(const ClientBase::SharedPtr& one) { remove(clients_, one); }
  void add_service(ServiceBase::SharedPtr one) { add(services_, std::move(one)); }
  void remove_service(const ServiceBase::SharedPtr& one) { remove(services_, one); }
  void prune_deleted_entities() {}

  /// Negative: for ever; on a thread that serves the graph, as in on_configure of a controller, 1 s: what
  /// comes from the graph does not arrive while that thread waits. Empty if the set has nothing to wait for.
  template <typename Rep = long, typename Ratio = std::milli>
  WaitResult<WaitSet> wait(
      std::chrono::duration<Rep, Ratio> timeout = std::chrono::duration<Rep, Ratio>(-1)) {
    auto span = std::chrono::duration_cast<std::chrono::nanoseconds>(timeout);
    if (span.count() < 0 && polyarm_ros::serves_graph()) span = std::chrono::seconds(1);
    const auto end = std::chrono::steady_clock::now() + span;
    while (ok()) {
      if (const WaitResultKind now = state(); now != Timeout) return WaitResult<WaitSet>(now, this);
      if (span.count() >= 0 && std::chrono::steady_clock::now() >= end) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return WaitResult<WaitSet>(Timeout, this);
  }
  const rcl_wait_set_t& get_rcl_wait_set() const { return listed_; }

  /// For WaitResult.
  auto& polyarm_subscriptions() { return subscriptions_; }
  auto& polyarm_timers() { return timers_; }
  auto& polyarm_clients() { return clients_; }
  auto& polyarm_services() { return services_; }

 protected:
  template <typename A, typename B, typename C, typename D, typename E>
  void add_all(const A& subscriptions, const B& conditions, const C& timers, const D& clients,
               const E& services) {
    for (const SubscriptionEntry& each : subscriptions) add_subscription(each.subscription, each.mask);
    for (const auto& each : conditions) add_guard_condition(each);
    for (const auto& each : timers) add_timer(each);
    for (const auto& each : clients) add_client(each);
    for (const auto& each : services) add_service(each);
  }

 private:
  template <typename T>
  void add(polyarm_ros::WaitedFor<T>& part, std::shared_ptr<T> one) {
    const std::lock_guard lock(mutex_);
    part.add(std::move(one));
  }
  template <typename T>
  void remove(polyarm_ros::WaitedFor<T>& part, const std::shared_ptr<T>& one) {
    const std::lock_guard lock(mutex_);
    part.remove(one);
  }
  WaitResultKind state() {
    const std::lock_guard lock(mutex_);
    if (subscriptions_.empty() && conditions_.empty() && timers_.empty() && clients_.empty() &&
        services_.empty())
      return Empty;
    const bool ready[] = {subscriptions_.look([](SubscriptionBase& each) { return each.has_message(); }),
                          conditions_.look([](GuardCondition& each) { return each.polyarm_take(); }),
                          timers_.look([](TimerBase& each) { return each.is_ready(); }),
                          clients_.look([](ClientBase& each) { return each.has_response(); }),
                          services_.look([](ServiceBase& each) { return each.has_request(); })};
    subscriptions_.list(listed_.subscriptions, listed_.size_of_subscriptions);
    conditions_.list(listed_.guard_conditions, listed_.size_of_guard_conditions);
    timers_.list(listed_.timers, listed_.size_of_timers);
    clients_.list(listed_.clients, listed_.size_of_clients);
    services_.list(listed_.services, listed_.size_of_services);
    return std::any_of(std::begin(ready), std::end(ready), [](bool each) { return each; }) ? Ready : Timeout;
  }
  std::mutex mutex_;
  polyarm_ros::WaitedFor<SubscriptionBase> subscriptions_{"subscription"};
  polyarm_ros::WaitedFor<GuardCondition> conditions_{"guard condition"};
  polyarm_ros::WaitedFor<TimerBase> timers_{"timer"};
  polyarm_ros::WaitedFor<ClientBase> clients_{"client"};
  polyarm_ros::WaitedFor<ServiceBase> services_{"service"};
  rcl_wait_set_t listed_;
};
using ThreadSafeWaitSet = WaitSet;

/// One whose parts are named at its construction.
template <std::size_t Subscriptions, std::size_t Conditions, std::size_t Timers, std::size_t Clients,
          std::size_t Services, std::size_t Waitables>
class StaticWaitSet : public WaitSet {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(StaticWaitSet)
  static_assert(Waitables == 0, "Polyarm's wait sets have no waitables");
  explicit StaticWaitSet(const std::array<SubscriptionEntry, Subscriptions>& subscriptions = {},
                         const std::array<GuardCondition::SharedPtr, Conditions>& conditions = {},
                         const std::array<TimerBase::SharedPtr, Timers>& timers = {},
                         const std::array<ClientBase::SharedPtr, Clients>& clients = {},
                         const std::array<ServiceBase::SharedPtr, Services>& services = {}) {
    add_all(subscriptions, conditions, timers, clients, services);
  }
};

}  // namespace rclcpp
