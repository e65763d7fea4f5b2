#pragma once
#include "rclcpp/wait_result_kind.hpp"

namespace rclcpp {
template <class Set>
class WaitResult {
 public:
  explicit WaitResult(WaitResultKind kind, Set* set = nullptr) : kind_(kind), set_(set) {}
  WaitResultKind kind() const { return kind_; }
  const Set& get_wait_set() const { return *set_; }
  Set& get_wait_set() { return *set_; }

 private:
  WaitResultKind kind_;
  Set* set_;
};
}  // namespace rclcpp
