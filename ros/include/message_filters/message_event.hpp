#pragma once
#include <memory>
#include <type_traits>
#include <utility>

#include "rclcpp/clock.hpp"
#include "rclcpp/rclcpp.hpp"

namespace message_filters {
/// A message and when it arrived.
template <typename M>
class MessageEvent {
 public:
  using Message = std::remove_const_t<M>;
  using ConstMessagePtr = std::shared_ptr<const Message>;
  using MessagePtr = std::shared_ptr<Message>;
  MessageEvent() = default;
  MessageEvent(ConstMessagePtr message)
      : MessageEvent(std::move(message), rclcpp::Clock().now()) {}  // NOLINT
  MessageEvent(ConstMessagePtr message, rclcpp::Time received)
      : message_(std::move(message)), received_(received) {}
  ConstMessagePtr getConstMessage() const { return message_; }
  std::shared_ptr<M> getMessage() const {
    if constexpr (std::is_const_v<M>)
      return message_;
    else
      return message_ ? std::make_shared<M>(*message_) : nullptr;
  }
  rclcpp::Time getReceiptTime() const { return received_; }

 private:
  ConstMessagePtr message_;
  rclcpp::Time received_;
};
}  // namespace message_filters
