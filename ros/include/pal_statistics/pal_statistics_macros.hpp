#pragma once
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "pal_statistics/pal_statistics.hpp"
#include "pal_statistics/registration_utils.hpp"

inline constexpr char DEFAULT_STATISTICS_TOPIC[] = "pal_statistics";

namespace pal_statistics {

/// The registry of a node's topic; the first caller makes it. It ends after its node, at the next call.
inline std::shared_ptr<StatisticsRegistry> registry_of(
    const rclcpp::node_interfaces::NodeCore::SharedPtr& core, const std::string& topic) {
  struct Place {
    std::weak_ptr<rclcpp::node_interfaces::NodeCore> core;
    std::shared_ptr<StatisticsRegistry> registry;
  };
  static std::mutex mutex;
  static std::map<std::string, Place> all;
  const std::lock_guard lock(mutex);
  for (auto at = all.begin(); at != all.end();)
    at = at->second.core.expired() ? all.erase(at) : std::next(at);
  Place& place = all[std::to_string(reinterpret_cast<std::uintptr_t>(core.get())) + " " + topic];
  if (!place.registry) place = {core, std::make_shared<StatisticsRegistry>(core, core, core, core, topic)};
  return place.registry;
}
template <typename NodePointer>
std::shared_ptr<StatisticsRegistry> getRegistry(const NodePointer& node, const std::string& topic) {
  return registry_of(node->get_node_base_interface(), topic);
}

}  // namespace pal_statistics

#define REGISTER_VARIABLE(node, topic, ...) \
  customRegister(*pal_statistics::getRegistry(node, topic), __VA_ARGS__);
#define REGISTER_VARIABLE_SIMPLE(node, topic, variable, bookkeeping) \
  customRegister(*pal_statistics::getRegistry(node, topic), #variable, variable, bookkeeping);
#define UNREGISTER_VARIABLE(node, topic, ...) \
  pal_statistics::getRegistry(node, topic)->unregisterVariable(__VA_ARGS__);
#define PUBLISH_STATISTICS(node, topic) pal_statistics::getRegistry(node, topic)->publish();
#define PUBLISH_ASYNC_STATISTICS(node, topic) pal_statistics::getRegistry(node, topic)->publishAsync();
#define START_PUBLISH_THREAD(node, topic) pal_statistics::getRegistry(node, topic)->startPublishThread();
#define PUBLISH_CUSTOM_STATISTIC(node, topic, id, value) \
  pal_statistics::getRegistry(node, topic)->publishCustomStatistic(id, value)
#define PUBLISH_CUSTOM_STATISTICS_MSG(node, topic, message) \
  pal_statistics::getRegistry(node, topic)->publishCustomStatistics(message)
