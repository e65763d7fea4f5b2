#pragma once
#include "message_filters/connection.hpp"
#include "message_filters/message_traits.hpp"

namespace message_filters {
/// In the place of inputs that a policy of fewer has not.
struct NullType {};
template <typename M>
struct NullFilter {
  template <typename Callback>
  Connection registerCallback(Callback&&) {
    return {};
  }
};
}  // namespace message_filters
