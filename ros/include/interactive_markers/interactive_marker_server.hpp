#pragma once
/// Markers that a person drags, as RViz shows them: TOPIC/update, TOPIC/feedback,
/// TOPIC/get_interactive_markers. Changes wait until applyChanges. Any thread; callbacks run in the executor
/// of the node.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rclcpp/rclcpp.hpp"
#include "visualization_msgs/msg/interactive_marker.hpp"
#include "visualization_msgs/msg/interactive_marker_feedback.hpp"
#include "visualization_msgs/msg/interactive_marker_update.hpp"
#include "visualization_msgs/srv/get_interactive_markers.hpp"

namespace interactive_markers {

class InteractiveMarkerServer {
  using Core = rclcpp::node_interfaces::NodeCore::SharedPtr;
  using Marker = visualization_msgs::msg::InteractiveMarker;
  using Update = visualization_msgs::msg::InteractiveMarkerUpdate;
  using Get = visualization_msgs::srv::GetInteractiveMarkers;

 public:
  using FeedbackConstPtr = std::shared_ptr<const visualization_msgs::msg::InteractiveMarkerFeedback>;
  using FeedbackCallback = std::function<void(const FeedbackConstPtr&)>;
  static constexpr std::uint8_t DEFAULT_FEEDBACK_CB = 255;

  template <typename NodePointer>
  InteractiveMarkerServer(const std::string& topic, NodePointer node,
                          const rclcpp::QoS& updates = rclcpp::QoS(100),
                          const rclcpp::QoS& feedback = rclcpp::QoS(1))
      : InteractiveMarkerServer(topic, node->get_node_base_interface(), updates, feedback) {}
  template <typename Clock, typename Logger, typename Topics, typename Services>
  InteractiveMarkerServer(const std::string& topic, const Core& base, const Clock&, const Logger&,
                          const Topics&, const Services&, const rclcpp::QoS& updates = rclcpp::QoS(100),
                          const rclcpp::QoS& feedback = rclcpp::QoS(1))
      : InteractiveMarkerServer(topic, base, updates, feedback) {}
  virtual ~InteractiveMarkerServer() = default;

  void insert(const Marker& marker) {
    const std::lock_guard lock(mutex_);
    waiting_[marker.name].marker = marker;
    waiting_[marker.name].erased = false;
  }
  void insert(const Marker& marker, FeedbackCallback call, std::uint8_t type = DEFAULT_FEEDBACK_CB) {
    const std::lock_guard lock(mutex_);
    waiting_[marker.name].marker = marker;
    waiting_[marker.name].erased = false;
    calls_[marker.name][type] = std::move(call);
  }
  bool setPose(const std::string& name, const geometry_msgs::msg::Pose& pose,
               const std_msgs::msg::Header& header = std_msgs::msg::Header()) {
    const std::lock_guard lock(mutex_);
    const auto found = shown_.find(name);
    const auto changed = waiting_.find(name);
    if (changed != waiting_.end() && changed->second.erased) return false;
    if (changed != waiting_.end() && changed->second.marker) {
      changed->second.marker->pose = pose;
      if (!header.frame_id.empty()) changed->second.marker->header = header;
      return true;
    }
    if (found == shown_.end()) return false;
    waiting_[name].pose = std::make_pair(header.frame_id.empty() ? found->second.header : header, pose);
    return true;
  }
  bool erase(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const bool known = shown_.count(name) > 0 || waiting_.count(name) > 0;
    if (!known) return false;
    waiting_[name] = Change{};
    waiting_[name].erased = true;
    calls_.erase(name);
    return true;
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
    calls_.clear();
    for (const auto& [name, marker] : shown_) waiting_[name].erased = true;
  }
  bool empty() const { return size() == 0; }
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return shown_.size();
  }
  bool setCallback(const std::string& name, FeedbackCallback call, std::uint8_t type = DEFAULT_FEEDBACK_CB) {
    const std::lock_guard lock(mutex_);
    if (!shown_.count(name) && !waiting_.count(name)) return false;
    if (call)
      calls_[name][type] = std::move(call);
    else
      calls_[name].erase(type);
    return true;
  }
  void applyChanges() {
    Update update;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.empty()) return;
      for (auto& [name, change] : waiting_) apply(name, change, update);
      waiting_.clear();
      update.type = Update::UPDATE;
      update.seq_num = ++number_;
    }
    publisher_->publish(update);
  }
  bool get(const std::string& name, Marker& out) const {
    const std::lock_guard lock(mutex_);
    const auto changed = waiting_.find(name);
    if (changed != waiting_.end() && changed->second.erased) return false;
    if (changed != waiting_.end() && changed->second.marker) return out = *changed->second.marker, true;
    const auto found = shown_.find(name);
    if (found == shown_.end()) return false;
    out = found->second;
    if (changed != waiting_.end() && changed->second.pose)
      out.header = changed->second.pose->first, out.pose = changed->second.pose->second;
    return true;
  }

 private:
  struct Change {
    std::optional<Marker> marker;
    std::optional<std::pair<std_msgs::msg::Header, geometry_msgs::msg::Pose>> pose;
    bool erased = false;
  };
  InteractiveMarkerServer(const std::string& topic, const Core& core, const rclcpp::QoS& updates,
                          const rclcpp::QoS& feedback) {
    polyarm_ros::NodeApi node(core);
    publisher_ = node.make_publisher<rclcpp::Publisher<Update>>(topic + "/update", updates);
    feedback_ = node.create_subscription<visualization_msgs::msg::InteractiveMarkerFeedback>(
        topic + "/feedback", feedback, [this](const FeedbackConstPtr& message) { take(message); });
    service_ = node.create_service<Get>(
        topic + "/get_interactive_markers",
        [this](const std::shared_ptr<Get::Request>, std::shared_ptr<Get::Response> response) {
          const std::lock_guard lock(mutex_);
          response->sequence_number = number_;
          for (const auto& [name, marker] : shown_) response->markers.push_back(marker);
        });
  }
  void apply(const std::string& name, Change& change, Update& update) {
    if (change.erased) {
      shown_.erase(name);
      update.erases.push_back(name);
    } else if (change.marker) {
      shown_[name] = *change.marker;
      update.markers.push_back(std::move(*change.marker));
    } else if (change.pose) {
      Marker& marker = shown_[name];
      marker.header = change.pose->first, marker.pose = change.pose->second;
      update.poses.emplace_back();
      update.poses.back().header = marker.header;
      update.poses.back().pose = marker.pose;
      update.poses.back().name = name;
    }
  }
  /// A drag moves the marker, and its callback hears of it.
  void take(const FeedbackConstPtr& message) {
    using Feedback = visualization_msgs::msg::InteractiveMarkerFeedback;
    FeedbackCallback call;
    {
      const std::lock_guard lock(mutex_);
      if (!shown_.count(message->marker_name)) return;
      const auto of_marker = calls_.find(message->marker_name);
      if (of_marker != calls_.end()) {
        auto found = of_marker->second.find(message->event_type);
        if (found == of_marker->second.end()) found = of_marker->second.find(DEFAULT_FEEDBACK_CB);
        if (found != of_marker->second.end()) call = found->second;
      }
    }
    if (message->event_type == Feedback::POSE_UPDATE)
      setPose(message->marker_name, message->pose, message->header);
    if (call) call(message);
  }
  mutable std::mutex mutex_;
  std::map<std::string, Marker> shown_;
  std::map<std::string, Change> waiting_;
  std::map<std::string, std::map<std::uint8_t, FeedbackCallback>> calls_;
  std::uint64_t number_ = 0;
  std::shared_ptr<rclcpp::Publisher<Update>> publisher_;
  std::shared_ptr<rclcpp::SubscriptionBase> feedback_;
  rclcpp::Service<Get>::SharedPtr service_;
};

}  // namespace interactive_markers
