#pragma once
#include <memory>
#include <string>
#include <utility>

#include "rclcpp/node.hpp"
#include "rclcpp_action/server.hpp"

namespace rclcpp_action {

/// With a node, or with its views (the first is as good as the others).
template <typename Action, typename Core, typename... Rest>
typename Server<Action>::SharedPtr create_server(
    std::shared_ptr<Core> base, std::shared_ptr<rclcpp::node_interfaces::NodeClockInterface>,
    std::shared_ptr<rclcpp::node_interfaces::NodeLoggingInterface>,
    std::shared_ptr<rclcpp::node_interfaces::NodeWaitablesInterface>, const std::string& name,
    typename Server<Action>::GoalCallback goal, typename Server<Action>::CancelCallback cancel,
    typename Server<Action>::AcceptedCallback accepted, Rest&&...) {
  auto server =
      std::make_shared<Server<Action>>(name, std::move(goal), std::move(cancel), std::move(accepted));
  if (!base->wires.open) polyarm_ros::report_unavailable(base->get_name(), "action", name);
  base->wires.add(server->polyarm_port());
  return server;
}
template <typename Action, typename NodePointer, typename... Rest>
auto create_server(NodePointer node, const std::string& name, typename Server<Action>::GoalCallback goal,
                   typename Server<Action>::CancelCallback cancel,
                   typename Server<Action>::AcceptedCallback accepted, Rest&&...)
    -> decltype(node->get_node_base_interface(), typename Server<Action>::SharedPtr()) {
  const auto core = node->get_node_base_interface();
  return create_server<Action>(core, core, core, core, name, std::move(goal), std::move(cancel),
                               std::move(accepted));
}

}  // namespace rclcpp_action
