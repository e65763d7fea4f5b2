#pragma once
#include "polyarm_ros/node_api.hpp"
#include "rclcpp_lifecycle/lifecycle_publisher.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"

namespace rclcpp_lifecycle {

class LifecycleNode : public node_interfaces::LifecycleNodeInterface,
                      public polyarm_ros::NodeApi,
                      public std::enable_shared_from_this<LifecycleNode> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(LifecycleNode)
  using CallbackReturn = node_interfaces::LifecycleNodeInterface::CallbackReturn;
  explicit LifecycleNode(const std::string& name, const rclcpp::NodeOptions& options = rclcpp::NodeOptions(),
                         bool = true)
      : NodeApi(name, options) {}
  LifecycleNode(const std::string& name, const std::string& name_space,
                const rclcpp::NodeOptions& options = rclcpp::NodeOptions(), bool = true)
      : NodeApi(name, name_space, options) {}

  template <typename Message, typename... Rest>
  typename LifecyclePublisher<Message>::SharedPtr create_publisher(const std::string& topic,
                                                                   const rclcpp::QoS&, Rest&&...) {
    return make_publisher<LifecyclePublisher<Message>>(topic);
  }
  const State& get_current_state() const { return state_; }
  /// For the wrapper, which changes the state of controllers.
  void polyarm_set_state(std::uint8_t id, const char* label) { state_ = State(id, label); }
  void add_managed_entity(std::weak_ptr<void>) {}

 private:
  State state_{lifecycle_msgs::msg::State::PRIMARY_STATE_UNCONFIGURED, "unconfigured"};
};

}  // namespace rclcpp_lifecycle
