#pragma once
/// What rclcpp::Node and LifecycleNode have in common.
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "rclcpp/client.hpp"
#include "rclcpp/generic_publisher.hpp"
#include "rclcpp/generic_subscription.hpp"
#include "rclcpp/node_interfaces/node_graph_interface.hpp"
#include "rclcpp/node_interfaces/node_interfaces.hpp"
#include "rclcpp/publisher.hpp"
#include "rclcpp/service.hpp"
#include "rclcpp/subscription.hpp"
#include "std_msgs/msg/string.hpp"

namespace polyarm_ros {

class NodeApi {
 public:
  NodeApi(const std::string& name, const std::string& name_space, const rclcpp::NodeOptions& options)
      : core_(std::make_shared<rclcpp::node_interfaces::NodeCore>(name, name_space, options)) {}
  NodeApi(const std::string& name, const rclcpp::NodeOptions& options) : NodeApi(name, "", options) {}
  /// Another view of a node that exists.
  explicit NodeApi(rclcpp::node_interfaces::NodeCore::SharedPtr core) : core_(std::move(core)) {}
  virtual ~NodeApi() = default;
  NodeApi(const NodeApi&) = delete;
  NodeApi& operator=(const NodeApi&) = delete;

  const char* get_name() const { return core_->get_name(); }
  const char* get_namespace() const { return core_->get_namespace(); }
  const char* get_fully_qualified_name() const { return core_->get_fully_qualified_name(); }
  std::string get_effective_namespace() const { return core_->get_namespace(); }
  rclcpp::Logger get_logger() const { return core_->get_logger(); }
  rclcpp::Clock::SharedPtr get_clock() const { return core_->get_clock(); }
  rclcpp::Time now() const { return core_->get_clock()->now(); }
  const rclcpp::NodeOptions& get_node_options() const { return core_->options(); }

  using Core = rclcpp::node_interfaces::NodeCore::SharedPtr;
  Core get_node_base_interface() const { return core_; }
  Core get_node_clock_interface() const { return core_; }
  Core get_node_logging_interface() const { return core_; }
  Core get_node_parameters_interface() const { return core_; }
  Core get_node_timers_interface() const { return core_; }
  Core get_node_topics_interface() const { return core_; }
  Core get_node_services_interface() const { return core_; }
  Core get_node_graph_interface() const { return core_; }
  Core get_node_waitables_interface() const { return core_; }
  Core get_node_time_source_interface() const { return core_; }

  rclcpp::CallbackGroup::SharedPtr create_callback_group(rclcpp::CallbackGroupType type, bool = true) {
    return core_->create_callback_group(type);
  }
  template <typename Message, typename Callback, typename... Rest>
  typename rclcpp::Subscription<Message>::SharedPtr create_subscription(const std::string& topic,
                                                                        const rclcpp::QoS& qos, Callback callback,
                                                                        Rest&&...) {
    const std::shared_ptr<Topic> on = find_topic(full(topic));
    auto listener = std::make_shared<Listener>(
        topic, &typeid(Message),
        [callback](const void* message) mutable {
          rclcpp::call_with_message(callback, *static_cast<const Message*>(message));
        },
        on, depth_of(qos));
    if constexpr (HasFields<Message>::value) {
      listener->type_name = Message::polyarm_type();
      listener->from_bytes = [](const Payload& payload) -> std::shared_ptr<const void> {
        auto message = std::make_shared<Message>();
        return decode(payload, *message) ? message : nullptr;
      };
    }
    listener->port =
        open_port<Message>(PortKind::subscription, get_fully_qualified_name(), topic, full(topic), qos);
    listener->take_from_port = take_from<Message>;
    on->add(listener);
    note("topic", topic, listener->port);
    core_->wires.add(listener);
    give_description<Message>(topic, *listener);
    return std::make_shared<rclcpp::Subscription<Message>>(std::move(listener));
  }
  template <typename Publisher>
  std::shared_ptr<Publisher> make_publisher(const std::string& topic, const rclcpp::QoS& qos) {
    using Message = typename Publisher::MessageType;
    auto speaker = std::make_shared<Speaker>(topic, &typeid(Message), find_topic(full(topic)));
    speaker->port =
        open_port<Message>(PortKind::publisher, get_fully_qualified_name(), topic, full(topic), qos);
    note("topic", topic, speaker->port);
    core_->wires.add(speaker);
    return std::make_shared<Publisher>(std::move(speaker));
  }
  template <typename... Rest>
  rclcpp::GenericPublisher::SharedPtr create_generic_publisher(const std::string& topic,
                                                               const std::string& type,
                                                               const rclcpp::QoS& qos, Rest&&...) {
    auto speaker = std::make_shared<Speaker>(topic, &typeid(Payload), find_topic(full(topic)));
    speaker->port =
        open_port_of(type, PortKind::publisher, get_fully_qualified_name(), topic, full(topic), qos);
    note("topic", topic, speaker->port);
    core_->wires.add(speaker);
    return std::make_shared<rclcpp::GenericPublisher>(std::move(speaker), type);
  }
  template <typename Callback, typename... Rest>
  rclcpp::GenericSubscription::SharedPtr create_generic_subscription(const std::string& topic,
                                                                     const std::string& type,
                                                                     const rclcpp::QoS& qos,
                                                                     Callback callback, Rest&&...) {
    const std::shared_ptr<Topic> on = find_topic(full(topic));
    auto listener = std::make_shared<Listener>(
        topic, &typeid(Payload),
        [callback](const void* payload) mutable {
          rclcpp::SerializedMessage message;
          message.polyarm_payload() = *static_cast<const Payload*>(payload);
          rclcpp::call_with_message(callback, message);
        },
        on, depth_of(qos));
    listener->type_name = type;
    listener->port =
        open_port_of(type, PortKind::subscription, get_fully_qualified_name(), topic, full(topic), qos);
    listener->take_from_port = take_bytes_from;
    on->add(listener);
    note("topic", topic, listener->port);
    core_->wires.add(listener);
    return std::make_shared<rclcpp::GenericSubscription>(std::move(listener));
  }
  /// For the wrapper of a controller.
  Wires& polyarm_wires() { return core_->wires; }
  template <typename Type, typename Callback, typename... Rest>
  typename rclcpp::Service<Type>::SharedPtr create_service(const std::string& name, Callback&& callback,
                                                           Rest&&...) {
    Port port = open_port<Type>(PortKind::service, get_fully_qualified_name(), name, full(name),
                                rclcpp::QoS(polyarm::hardware::LetterQueue::kMost));
    note("service", name, port);
    auto service =
        std::make_shared<rclcpp::Service<Type>>(name, std::move(port), std::forward<Callback>(callback));
    core_->wires.add(std::shared_ptr<Callee>(service));
    rclcpp::LocalServices::add(full(name), service);
    return service;
  }
  template <typename Type, typename... Rest>
  typename rclcpp::Client<Type>::SharedPtr create_client(const std::string& name, Rest&&...) {
    Port port = open_port<Type>(PortKind::client, get_fully_qualified_name(), name, full(name),
                                rclcpp::QoS(polyarm::hardware::LetterQueue::kMost));
    auto client = std::make_shared<rclcpp::Client<Type>>(name, full(name), std::move(port));
    core_->wires.add(std::shared_ptr<Callee>(client));
    return client;
  }
  template <typename Rep, typename Ratio, typename Callback>
  typename rclcpp::WallTimer<>::SharedPtr create_wall_timer(std::chrono::duration<Rep, Ratio> period,
                                                            Callback callback,
                                                            rclcpp::CallbackGroup::SharedPtr = nullptr,
                                                            bool = true) {
    auto timer = std::make_shared<rclcpp::WallTimer<>>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(period),
        [callback](rclcpp::TimerBase& t) mutable {
          if constexpr (std::is_invocable_v<Callback&, rclcpp::TimerBase&>)
            callback(t);
          else
            callback();
        },
        core_->timer_source);
    core_->add_timer(timer);
    return timer;
  }
  template <typename Rep, typename Ratio, typename Callback>
  rclcpp::TimerBase::SharedPtr create_timer(std::chrono::duration<Rep, Ratio> period, Callback callback,
                                            rclcpp::CallbackGroup::SharedPtr group = nullptr) {
    return create_wall_timer(period, std::move(callback), group);
  }

  using Descriptor = rcl_interfaces::msg::ParameterDescriptor;
  template <typename T>
  auto declare_parameter(const std::string& name, const T& value, const Descriptor& descriptor = {},
                         bool = false) {
    const rclcpp::ParameterValue& set =
        core_->declare_parameter(name, rclcpp::ParameterValue(value), descriptor);
    if constexpr (std::is_convertible_v<T, std::string>)
      return set.get<std::string>();
    else
      return set.get<T>();
  }
  template <typename T>
  T declare_parameter(const std::string& name, const Descriptor& descriptor = {}, bool = false) {
    return core_->declare_parameter(name, rclcpp::ParameterValue(T{}), descriptor).template get<T>();
  }
  const rclcpp::ParameterValue& declare_parameter(const std::string& name,
                                                  const rclcpp::ParameterValue& value,
                                                  const Descriptor& descriptor = {}, bool = false) {
    return core_->declare_parameter(name, value, descriptor);
  }
  const rclcpp::ParameterValue& declare_parameter(const std::string& name, rclcpp::ParameterType,
                                                  const Descriptor& descriptor = {}, bool = false) {
    return core_->declare_parameter(name, rclcpp::ParameterValue{}, descriptor);
  }
  /// Parameters below `name_space`, each with its default; the values that they got.
  template <typename T>
  std::vector<T> declare_parameters(const std::string& name_space, const std::map<std::string, T>& all,
                                    bool = false) {
    std::vector<T> out;
    for (const auto& [name, value] : all)
      out.push_back(declare_parameter(name_space.empty() ? name : name_space + "." + name, value));
    return out;
  }
  void undeclare_parameter(const std::string& name) { core_->undeclare_parameter(name); }
  bool has_parameter(const std::string& name) const { return core_->knows_parameter(name); }
  rclcpp::Parameter get_parameter(const std::string& name) const { return core_->get_parameter(name); }
  bool get_parameter(const std::string& name, rclcpp::Parameter& out) const {
    return core_->get_parameter(name, out);
  }
  template <typename T>
  bool get_parameter(const std::string& name, T& out) const {
    rclcpp::Parameter found;
    if (!core_->get_parameter(name, found)) return false;
    out = found.get_value<T>();
    return true;
  }
  template <typename T>
  bool get_parameter_or(const std::string& name, T& out, const T& otherwise) const {
    if (get_parameter(name, out)) return true;
    out = otherwise;
    return false;
  }
  std::vector<rclcpp::Parameter> get_parameters(const std::vector<std::string>& names) const {
    return core_->get_parameters(names);
  }
  bool get_parameters(const std::string& prefix, std::map<std::string, rclcpp::Parameter>& out) const {
    return core_->get_parameters_by_prefix(prefix, out);
  }
  auto list_parameters(const std::vector<std::string>& prefixes, std::uint64_t depth) const {
    return core_->list_parameters(prefixes, depth);
  }
  Descriptor describe_parameter(const std::string& name) const {
    return core_->describe_parameters({name}).front();
  }
  auto describe_parameters(const std::vector<std::string>& names) const {
    return core_->describe_parameters(names);
  }
  auto get_parameter_types(const std::vector<std::string>& names) const {
    return core_->get_parameter_types(names);
  }
  auto set_parameter(const rclcpp::Parameter& p) { return core_->set_parameter(p); }
  auto set_parameters(const std::vector<rclcpp::Parameter>& all) { return core_->set_parameters(all); }
  auto set_parameters_atomically(const std::vector<rclcpp::Parameter>& all) {
    return core_->set_parameters_atomically(all);
  }
  auto add_on_set_parameters_callback(rclcpp::node_interfaces::ParametersCallback callback) {
    return core_->add_on_set_parameters_callback(std::move(callback));
  }
  auto add_post_set_parameters_callback(std::function<void(const std::vector<rclcpp::Parameter>&)> callback) {
    return core_->add_post_set_parameters_callback(std::move(callback));
  }
  void remove_on_set_parameters_callback(
      const rclcpp::node_interfaces::OnSetParametersCallbackHandle* handle) {
    core_->remove_on_set_parameters_callback(handle);
  }

  std::vector<std::string> get_node_names() const { return {core_->get_fully_qualified_name()}; }
  std::map<std::string, std::vector<std::string>> get_topic_names_and_types() const { return {}; }
  std::map<std::string, std::vector<std::string>> get_service_names_and_types() const { return {}; }
  std::size_t count_publishers(const std::string& topic) const {
    return static_cast<std::size_t>(find_topic(full(topic))->speakers.load());
  }
  /// Publishers and subscriptions of this module; their nodes and types are not named.
  std::vector<rclcpp::TopicEndpointInfo> get_publishers_info_by_topic(const std::string& topic,
                                                                      bool = false) const {
    using Info = rclcpp::TopicEndpointInfo;
    return std::vector<Info>(count_publishers(topic), Info(rclcpp::EndpointType::Publisher));
  }
  std::vector<rclcpp::TopicEndpointInfo> get_subscriptions_info_by_topic(const std::string& topic,
                                                                         bool = false) const {
    using Info = rclcpp::TopicEndpointInfo;
    return std::vector<Info>(count_subscribers(topic), Info(rclcpp::EndpointType::Subscription));
  }
  std::size_t count_subscribers(const std::string& topic) const {
    return static_cast<std::size_t>(find_topic(full(topic))->listeners.load());
  }

 private:
  /// In ROS the robot's description waits on a topic for those who come later.
  template <typename Message>
  void give_description(const std::string& topic, Listener& listener) const {
    if constexpr (std::is_same_v<Message, std_msgs::msg::String>) {
      const std::string& text = core_->polyarm_robot_description;
      if (text.empty() || (topic != "robot_description" && topic != "/robot_description")) return;
      auto message = std::make_shared<Message>();
      message->data = text;
      listener.take(std::move(message));
    }
  }
  std::string full(const std::string& topic) const {
    return full_topic(get_namespace(), get_fully_qualified_name(), topic);
  }
  void note(const char* what, const std::string& name, const Port& port) const {
    if (!port && !core_->wires.open) report_unavailable(get_name(), what, name);
  }
  Core core_;
};

}  // namespace polyarm_ros
