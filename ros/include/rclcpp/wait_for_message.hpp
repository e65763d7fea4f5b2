#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "polyarm_ros/wires.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp/utilities.hpp"

namespace rclcpp {
/// The next message of the subscription, within the timeout of the steady clock (negative: for ever). A
/// thread that serves the graph itself, as in on_configure of a controller, does not wait for ever.
template <typename Message, typename Rep = long, typename Period = std::milli>
bool wait_for_message(Message& out, std::shared_ptr<Subscription<Message>> subscription, Context::SharedPtr,
                      std::chrono::duration<Rep, Period> timeout = std::chrono::duration<Rep, Period>(-1)) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  MessageInfo info;
  while (ok()) {
    if (subscription->take(out, info)) return true;
    if (timeout.count() < 0 ? polyarm_ros::serves_graph() : std::chrono::steady_clock::now() >= end)
      return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}
/// The next message of a topic.
template <typename Message, typename NodePointer, typename Rep = long, typename Period = std::milli>
auto wait_for_message(Message& out, NodePointer node, const std::string& topic,
                      std::chrono::duration<Rep, Period> timeout = std::chrono::duration<Rep, Period>(-1),
                      const QoS& qos = SystemDefaultsQoS()) -> decltype(node->get_name(), bool()) {
  const auto subscription =
      node->template create_subscription<Message>(topic, qos, [](const std::shared_ptr<Message>&) {});
  return wait_for_message(out, subscription, nullptr, timeout);
}
}  // namespace rclcpp
