#pragma once
#include "polyarm_ros/node_api.hpp"
#include "rclcpp/logging.hpp"

namespace rclcpp {

class Node : public polyarm_ros::NodeApi, public std::enable_shared_from_this<Node> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Node)
  explicit Node(const std::string& name, const NodeOptions& options = NodeOptions())
      : NodeApi(name, options) {}
  explicit Node(const std::string& name, const std::string& name_space,
                const NodeOptions& options = NodeOptions())
      : NodeApi(name, name_space, options) {}

  template <typename Message, typename... Rest>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, const QoS& qos,
                                                          Rest&&...) {
    return make_publisher<Publisher<Message>>(topic, qos);
  }
};

/// True for the interfaces of a node, which serve as the node below.
template <typename NodePointer>
inline constexpr bool is_node_interface_v =
    std::is_convertible_v<NodePointer, node_interfaces::NodeCore::SharedPtr>;

template <typename Message, typename NodePointer, typename... Rest>
auto create_publisher(NodePointer&& node, const std::string& topic, const QoS& qos, Rest&&...) {
  if constexpr (is_node_interface_v<NodePointer>)
    return polyarm_ros::NodeApi(node).template make_publisher<Publisher<Message>>(topic, qos);
  else
    return node->template create_publisher<Message>(topic, qos);
}
template <typename Message, typename NodePointer, typename Callback, typename... Rest>
auto create_subscription(NodePointer&& node, const std::string& topic, const QoS& qos, Callback&& call,
                         Rest&&...) {
  if constexpr (is_node_interface_v<NodePointer>)
    return polyarm_ros::NodeApi(node).template create_subscription<Message>(topic, qos,
                                                                            std::forward<Callback>(call));
  else
    return node->template create_subscription<Message>(topic, qos, std::forward<Callback>(call));
}
template <typename Type, typename NodePointer, typename Callback, typename... Rest>
auto create_service(NodePointer&& node, const std::string& name, Callback&& call, Rest&&...) {
  return node->template create_service<Type>(name, std::forward<Callback>(call));
}
template <typename Type, typename NodePointer, typename... Rest>
auto create_client(NodePointer&& node, const std::string& name, Rest&&...) {
  return node->template create_client<Type>(name);
}
/// Its clock is the node's.
template <typename NodePointer, typename Callback, typename... Rest>
TimerBase::SharedPtr create_timer(NodePointer&& node, const Clock::SharedPtr&, const Duration& period,
                                  Callback&& call, Rest&&...) {
  return node->create_wall_timer(std::chrono::nanoseconds(period.nanoseconds()),
                                 std::forward<Callback>(call));
}

}  // namespace rclcpp
