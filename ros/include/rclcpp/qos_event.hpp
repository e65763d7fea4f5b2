#pragma once
/// Callbacks for events of the middleware. They are taken, and never called: the graph reports no such events
/// to plugins.
#include <cstdint>
#include <functional>
#include <string>

namespace rclcpp {

struct QOSCountedEvent {
  std::int32_t total_count = 0, total_count_change = 0;
};
using QOSDeadlineRequestedInfo = QOSCountedEvent;
using QOSDeadlineOfferedInfo = QOSCountedEvent;
struct QOSLivelinessChangedInfo {
  std::int32_t alive_count = 0, not_alive_count = 0, alive_count_change = 0, not_alive_count_change = 0;
};
using QOSLivelinessLostInfo = QOSCountedEvent;
struct QOSMessageLostInfo {
  std::size_t total_count = 0, total_count_change = 0;
};
struct QOSOfferedIncompatibleQoSInfo : QOSCountedEvent {
  int last_policy_kind = 0;
};
using QOSRequestedIncompatibleQoSInfo = QOSOfferedIncompatibleQoSInfo;
using IncompatibleTypeInfo = QOSCountedEvent;
struct MatchedInfo {
  std::size_t total_count = 0, total_count_change = 0, current_count = 0;
  std::int32_t current_count_change = 0;
};

struct PublisherEventCallbacks {
  std::function<void(QOSDeadlineOfferedInfo&)> deadline_callback;
  std::function<void(QOSLivelinessLostInfo&)> liveliness_callback;
  std::function<void(QOSOfferedIncompatibleQoSInfo&)> incompatible_qos_callback;
  std::function<void(IncompatibleTypeInfo&)> incompatible_type_callback;
  std::function<void(MatchedInfo&)> matched_callback;
};
struct SubscriptionEventCallbacks {
  std::function<void(QOSDeadlineRequestedInfo&)> deadline_callback;
  std::function<void(QOSLivelinessChangedInfo&)> liveliness_callback;
  std::function<void(QOSRequestedIncompatibleQoSInfo&)> incompatible_qos_callback;
  std::function<void(QOSMessageLostInfo&)> message_lost_callback;
  std::function<void(IncompatibleTypeInfo&)> incompatible_type_callback;
  std::function<void(MatchedInfo&)> matched_callback;
};

enum class IntraProcessSetting { Enable, Disable, NodeDefault };
/// Policies that a parameter file may change; Polyarm reads none.
class QosOverridingOptions {
 public:
  QosOverridingOptions() = default;
  static QosOverridingOptions with_default_policies() { return {}; }
};

}  // namespace rclcpp
