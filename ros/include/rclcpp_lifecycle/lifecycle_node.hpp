#pragma once
#include <array>
#include <functional>

#include "polyarm_ros/node_api.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp_lifecycle/lifecycle_publisher.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"

namespace rclcpp_lifecycle {

/// Also an rclcpp::Node, as the nodes of Foxy's controllers are: code may take it for either.
class LifecycleNode : public node_interfaces::LifecycleNodeInterface, public rclcpp::Node {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(LifecycleNode)
  using CallbackReturn = node_interfaces::LifecycleNodeInterface::CallbackReturn;
  explicit LifecycleNode(const std::string& name, const rclcpp::NodeOptions& options = rclcpp::NodeOptions(),
                         bool = true)
      : Node(name, options) {}
  LifecycleNode(const std::string& name, const std::string& name_space,
                const rclcpp::NodeOptions& options = rclcpp::NodeOptions(), bool = true)
      : Node(name, name_space, options) {}

  std::shared_ptr<LifecycleNode> shared_from_this() {
    return std::static_pointer_cast<LifecycleNode>(Node::shared_from_this());
  }
  std::shared_ptr<const LifecycleNode> shared_from_this() const {
    return std::static_pointer_cast<const LifecycleNode>(Node::shared_from_this());
  }
  template <typename Message, typename... Rest>
  typename LifecyclePublisher<Message>::SharedPtr create_publisher(const std::string& topic,
                                                                   const rclcpp::QoS& qos, Rest&&...) {
    return make_publisher<LifecyclePublisher<Message>>(topic, qos);
  }
  const State& get_current_state() const { return state_; }
  /// For the wrapper, which changes the state of controllers.
  void polyarm_set_state(std::uint8_t id, const char* label) { state_ = State(id, label); }
  void add_managed_entity(std::weak_ptr<void>) {}

  using Callback = std::function<CallbackReturn(const State&)>;
  bool register_on_configure(Callback call) { return callbacks_[0] = std::move(call), true; }
  bool register_on_cleanup(Callback call) { return callbacks_[1] = std::move(call), true; }
  bool register_on_activate(Callback call) { return callbacks_[2] = std::move(call), true; }
  bool register_on_deactivate(Callback call) { return callbacks_[3] = std::move(call), true; }
  bool register_on_shutdown(Callback call) { return callbacks_[4] = std::move(call), true; }
  bool register_on_error(Callback call) { return callbacks_[5] = std::move(call), true; }

  /// Transitions of the life cycle, where the node itself makes them. One that does not fit the state does nothing.
  const State& configure() { return change(1, 0, {2, "inactive"}); }
  const State& cleanup() { return change(2, 1, {1, "unconfigured"}); }
  const State& activate() { return change(2, 2, {3, "active"}); }
  const State& deactivate() { return change(3, 3, {2, "inactive"}); }
  const State& shutdown() { return change(state_.id() < 4 ? state_.id() : 0, 4, {4, "finalized"}); }
  template <typename Code>
  const State& configure(Code& code) {
    return note(configure(), 2, code);
  }
  template <typename Code>
  const State& activate(Code& code) {
    return note(activate(), 3, code);
  }
  template <typename Code>
  const State& deactivate(Code& code) {
    return note(deactivate(), 2, code);
  }
  const State& trigger_transition(std::uint8_t id) {
    using Transition = lifecycle_msgs::msg::Transition;
    if (id == Transition::TRANSITION_CONFIGURE) return configure();
    if (id == Transition::TRANSITION_CLEANUP) return cleanup();
    if (id == Transition::TRANSITION_ACTIVATE) return activate();
    if (id == Transition::TRANSITION_DEACTIVATE) return deactivate();
    return id >= Transition::TRANSITION_UNCONFIGURED_SHUTDOWN && id <= Transition::TRANSITION_ACTIVE_SHUTDOWN
               ? shutdown()
               : state_;
  }

 private:
  CallbackReturn call(std::size_t which) {
    if (callbacks_[which]) return callbacks_[which](state_);
    switch (which) {
      case 0: return on_configure(state_);
      case 1: return on_cleanup(state_);
      case 2: return on_activate(state_);
      case 3: return on_deactivate(state_);
      case 4: return on_shutdown(state_);
      default: return on_error(state_);
    }
  }
  const State& change(std::uint8_t from, std::size_t which, State to) {
    if (state_.id() != from) return state_;
    CallbackReturn result = CallbackReturn::ERROR;
    try {
      result = call(which);
    } catch (const std::exception& e) {
      RCLCPP_ERROR(get_logger(), "%s", e.what());
    }
    if (result == CallbackReturn::SUCCESS)
      state_ = to;
    else if (result == CallbackReturn::ERROR)
      state_ = call(5) == CallbackReturn::SUCCESS ? State(1, "unconfigured") : State(4, "finalized");
    return state_;
  }
  template <typename Code>
  static const State& note(const State& state, std::uint8_t wanted, Code& code) {
    code = state.id() == wanted ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
    return state;
  }
  std::array<Callback, 6> callbacks_;  ///< configure, cleanup, activate, deactivate, shutdown, error
  State state_{lifecycle_msgs::msg::State::PRIMARY_STATE_UNCONFIGURED, "unconfigured"};
};

}  // namespace rclcpp_lifecycle
