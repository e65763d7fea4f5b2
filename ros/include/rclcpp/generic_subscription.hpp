#pragma once
#include "rclcpp/serialized_message.hpp"
#include "rclcpp/subscription.hpp"

namespace rclcpp {
/// Gets payloads of a type that it knows by its name only.
class GenericSubscription : public SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(GenericSubscription)
  using SubscriptionBase::SubscriptionBase;
};
}  // namespace rclcpp
