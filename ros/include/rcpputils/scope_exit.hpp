#pragma once
#include <utility>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
/// Calls a function at the end of its scope, unless it is cancelled.
template <typename Function>
class scope_exit {
 public:
  explicit scope_exit(Function call) : call_(std::move(call)) {}
  scope_exit(scope_exit&& other)
      : call_(std::move(other.call_)), armed_(std::exchange(other.armed_, false)) {}
  scope_exit(const scope_exit&) = delete;
  scope_exit& operator=(const scope_exit&) = delete;
  ~scope_exit() {
    if (armed_) call_();
  }
  void cancel() { armed_ = false; }

 private:
  Function call_;
  bool armed_ = true;
};
template <typename Function>
scope_exit<Function> make_scope_exit(Function call) {
  return scope_exit<Function>(std::move(call));
}
}  // namespace rcpputils
#define RCPPUTILS_SCOPE_EXIT_JOIN_IN_(a, b) a##b
#define RCPPUTILS_SCOPE_EXIT_JOIN_(a, b) RCPPUTILS_SCOPE_EXIT_JOIN_IN_(a, b)
#define RCPPUTILS_SCOPE_EXIT(...)                                           \
  const auto RCPPUTILS_SCOPE_EXIT_JOIN_(polyarm_at_scope_exit_, __LINE__) = \
      rcpputils::make_scope_exit([&]() { __VA_ARGS__; })
