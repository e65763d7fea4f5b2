#pragma once
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "message_filters/simple_filter.hpp"
#include "rclcpp/rclcpp.hpp"

namespace message_filters {

class SubscriberBase {
 public:
  using SharedPtr = std::shared_ptr<SubscriberBase>;
  virtual ~SubscriberBase() = default;
  virtual void subscribe() = 0;
  virtual void unsubscribe() = 0;
};

/// A subscription of a node, as a filter's input. The quality of service is rclcpp::QoS or the profile of
/// rmw.
template <typename M, typename NodeType = rclcpp::Node>
class Subscriber : public SubscriberBase, public SimpleFilter<M> {
 public:
  using MessageType = M;
  using typename SimpleFilter<M>::EventType;
  using typename SimpleFilter<M>::MConstPtr;

  Subscriber() = default;
  template <typename NodePointer, typename... Rest>
  Subscriber(NodePointer&& node, const std::string& topic, Rest&&... rest) {
    subscribe(std::forward<NodePointer>(node), topic, std::forward<Rest>(rest)...);
  }
  ~Subscriber() override { unsubscribe(); }

  template <typename NodePointer, typename... Rest>
  void subscribe(NodePointer&& node, const std::string& topic, Rest&&... rest) {
    auto core = core_of(node);
    const rclcpp::QoS qos = qos_of(std::forward<Rest>(rest)...);
    topic_ = topic;
    again_ = [this, core, qos, topic] {
      polyarm_ros::NodeApi api(core);
      subscription_ = api.template create_subscription<M>(
          topic, qos, [this](const MConstPtr& m) { this->signalMessage(m); });
    };
    again_();
  }
  void subscribe() override {
    if (!subscription_ && again_) again_();
  }
  void unsubscribe() override { subscription_.reset(); }
  std::string getTopic() const { return topic_; }
  typename rclcpp::Subscription<M>::SharedPtr getSubscriber() const { return subscription_; }
  template <typename Filter>
  void connectInput(Filter&) {}
  void add(const EventType&) {}

 private:
  template <typename NodePointer>
  static auto core_of(const NodePointer& node) {
    if constexpr (std::is_convertible_v<NodePointer, rclcpp::node_interfaces::NodeCore::SharedPtr>)
      return rclcpp::node_interfaces::NodeCore::SharedPtr(node);
    else
      return node->get_node_base_interface();
  }
  static rclcpp::QoS qos_of() { return rclcpp::QoS(10); }
  template <typename Quality, typename... Rest>
  static rclcpp::QoS qos_of(const Quality& quality, Rest&&...) {
    if constexpr (std::is_convertible_v<const Quality&, rclcpp::QoS>)
      return quality;
    else
      return rclcpp::QoS(rclcpp::QoSInitialization::from_rmw(quality), quality);
  }
  typename rclcpp::Subscription<M>::SharedPtr subscription_;
  std::function<void()> again_;
  std::string topic_;
};

}  // namespace message_filters
