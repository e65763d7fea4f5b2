#pragma once
#include "rclcpp/serialized_message.hpp"
#include "rclcpp/subscription.hpp"

namespace rclcpp {
/// Gets payloads of a type that it knows by its name only.
class GenericSubscription : public SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(GenericSubscription)
  using SubscriptionBase::SubscriptionBase;
  bool take_serialized(SerializedMessage& out, MessageInfo&) {
    const auto payload = listener_->next();
    if (payload) out.polyarm_payload() = *static_cast<const polyarm_ros::Payload*>(payload.get());
    return payload != nullptr;
  }
  std::shared_ptr<void> create_message() override { return std::make_shared<SerializedMessage>(); }
  bool take_type_erased(void* out, MessageInfo& info) override {
    return take_serialized(*static_cast<SerializedMessage*>(out), info);
  }

 protected:
  const void* polyarm_message(void* message) const override {
    return &static_cast<SerializedMessage*>(message)->polyarm_payload();
  }
};
}  // namespace rclcpp
