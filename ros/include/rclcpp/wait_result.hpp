#pragma once
#include <cstddef>
#include <memory>

#include "rclcpp/wait_result_kind.hpp"

namespace rclcpp {

/// The end of a wait. Each next_ready_… returns what was ready at that time, one after the other, and null
/// after the last one.
template <class Set>
class WaitResult {
 public:
  explicit WaitResult(WaitResultKind kind, Set* set = nullptr) : kind_(kind), set_(set) {}
  WaitResultKind kind() const { return kind_; }
  const Set& get_wait_set() const { return *set_; }
  Set& get_wait_set() { return *set_; }

  auto next_ready_subscription() { return next(set_->polyarm_subscriptions()); }
  auto next_ready_timer() { return next(set_->polyarm_timers()); }
  auto next_ready_client() { return next(set_->polyarm_clients()); }
  auto next_ready_service() { return next(set_->polyarm_services()); }

 private:
  template <typename Part>
  static auto next(Part& part) -> decltype(part.next_ready()) {
    return part.next_ready();
  }
  WaitResultKind kind_;
  Set* set_;
};

}  // namespace rclcpp
