#pragma once
/// Variables that are published by name: TOPIC/full, TOPIC/names and TOPIC/values. Any thread. `publishAsync`
/// allocates nothing and waits for nobody: a thread sends what it copied. Polyarm records the interfaces of
/// the cell without it.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pal_statistics/pal_statistics_utils.hpp"
#include "pal_statistics_msgs/msg/statistics.hpp"
#include "pal_statistics_msgs/msg/statistics_names.hpp"
#include "pal_statistics_msgs/msg/statistics_values.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp_lifecycle/lifecycle_node.hpp"

namespace pal_statistics {

class StatisticsRegistry : public std::enable_shared_from_this<StatisticsRegistry> {
  using Core = rclcpp::node_interfaces::NodeCore::SharedPtr;
  using Names = pal_statistics_msgs::msg::StatisticsNames;
  using Values = pal_statistics_msgs::msg::StatisticsValues;
  using Full = pal_statistics_msgs::msg::Statistics;

 public:
  StatisticsRegistry(const Core&, const Core& topics, const Core&, const Core&, const std::string& topic)
      : clock_(topics->get_clock()) {
    polyarm_ros::NodeApi node(topics);
    pub_ = node.make_publisher<rclcpp::Publisher<Full>>(topic + "/full", rclcpp::QoS(100));
    pub_names_ =
        node.make_publisher<rclcpp::Publisher<Names>>(topic + "/names", rclcpp::QoS(100).transient_local());
    pub_values_ = node.make_publisher<rclcpp::Publisher<Values>>(topic + "/values", rclcpp::QoS(100));
  }
  StatisticsRegistry(const std::shared_ptr<rclcpp::Node>& node, const std::string& topic)
      : StatisticsRegistry(node->get_node_base_interface(), topic) {}
  StatisticsRegistry(const rclcpp_lifecycle::LifecycleNode::SharedPtr& node, const std::string& topic)
      : StatisticsRegistry(node->get_node_base_interface(), topic) {}
  virtual ~StatisticsRegistry() { joinPublisherThread(); }

  IdType registerVariable(const std::string& name, const double* variable,
                          RegistrationsRAII* bookkeeping = nullptr, bool enabled = true) {
    return registerFunction(
        name, [variable] { return *variable; }, bookkeeping, enabled);
  }
  IdType registerFunction(const std::string& name, const std::function<double()>& value,
                          RegistrationsRAII* bookkeeping = nullptr, bool enabled = true) {
    const std::lock_guard lock(mutex_);
    all_.push_back({name, value, ++last_id_, enabled});
    rename();
    if (bookkeeping) bookkeeping->add(Registration(name, last_id_, weak_from_this()));
    return last_id_;
  }
  void unregisterVariable(const std::string& name, RegistrationsRAII* bookkeeping = nullptr) {
    if (bookkeeping && bookkeeping->remove(name)) return;
    remove_if([&](const Variable& v) { return v.name == name; });
  }
  void unregisterVariable(IdType id, RegistrationsRAII* bookkeeping = nullptr) {
    if (bookkeeping && bookkeeping->remove(id)) return;
    remove_if([&](const Variable& v) { return v.id == id; });
  }
  bool enable(const IdType& id) { return set_enabled(id, true); }
  bool disable(const IdType& id) { return set_enabled(id, false); }

  void publish() {
    std::unique_lock lock(mutex_);
    copy();
    send(lock);
  }
  /// False if another thread is using the registry, or if the last values were not sent yet.
  bool publishAsync() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock() || waiting_) return false;
    copy();
    waiting_ = true;
    return true;
  }
  void startPublishThread() {
    if (thread_.joinable()) return;
    thread_ = std::thread([this] {
      while (!ended_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::unique_lock lock(mutex_);
        if (waiting_) send(lock);
      }
    });
  }
  Full createMsg() {
    const std::lock_guard lock(mutex_);
    copy();
    return full();
  }
  template <typename T>
  void publishCustomStatistic(const std::string& name, T value) {
    Full message;
    message.header.stamp = clock_->now();
    message.statistics.emplace_back();
    message.statistics.back().name = name;
    message.statistics.back().value = static_cast<double>(value);
    pub_->publish(message);
  }
  void publishCustomStatistics(const Full& message) { pub_->publish(message); }

 protected:
  void joinPublisherThread() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  struct Variable {
    std::string name;
    std::function<double()> value;
    IdType id;
    bool enabled;
  };
  StatisticsRegistry(const Core& core, const std::string& topic)
      : StatisticsRegistry(core, core, core, core, topic) {}

  template <typename Test>
  void remove_if(Test test) {
    const std::lock_guard lock(mutex_);
    for (auto at = all_.begin(); at != all_.end();) at = test(*at) ? all_.erase(at) : at + 1;
    rename();
  }
  bool set_enabled(IdType id, bool enabled) {
    const std::lock_guard lock(mutex_);
    for (Variable& v : all_)
      if (v.id == id) {
        v.enabled = enabled;
        rename();
        return true;
      }
    return false;
  }
  void rename() {
    names_.names.clear();
    for (const Variable& v : all_)
      if (v.enabled) names_.names.push_back(v.name);
    values_.values.assign(names_.names.size(), 0.0);
    names_.names_version = values_.names_version = names_.names_version + 1;
    renamed_ = true;
    waiting_ = false;  // values of other names
  }
  void copy() {
    std::size_t i = 0;
    for (const Variable& v : all_)
      if (v.enabled) values_.values[i++] = v.value();
    values_.header.stamp = clock_->now();
  }
  Full full() const {
    Full message;
    message.header.stamp = values_.header.stamp;
    message.statistics.resize(values_.values.size());
    for (std::size_t i = 0; i < values_.values.size(); ++i) {
      message.statistics[i].name = names_.names[i];
      message.statistics[i].value = values_.values[i];
    }
    return message;
  }
  /// Sends copies after the lock has ended.
  void send(std::unique_lock<std::mutex>& lock) {
    const bool renamed = std::exchange(renamed_, false);
    waiting_ = false;
    names_.header.stamp = values_.header.stamp;
    const Full message = full();
    const Values values = values_;
    const Names names = names_;
    lock.unlock();
    if (renamed) pub_names_->publish(names);
    pub_values_->publish(values);
    pub_->publish(message);
  }

  rclcpp::Clock::SharedPtr clock_;
  rclcpp::Publisher<Full>::SharedPtr pub_;
  rclcpp::Publisher<Names>::SharedPtr pub_names_;
  rclcpp::Publisher<Values>::SharedPtr pub_values_;
  std::mutex mutex_;
  std::vector<Variable> all_;
  IdType last_id_ = 0;
  Names names_;
  Values values_;
  bool renamed_ = false, waiting_ = false;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

inline Registration::~Registration() {
  if (const auto owner = owner_.lock()) owner->unregisterVariable(id_);
}
inline bool RegistrationsRAII::set_all(bool enabled) {
  bool all = true;
  for (const auto& each : all_)
    if (const auto owner = each->owner_.lock())
      all = (enabled ? owner->enable(each->id_) : owner->disable(each->id_)) && all;
  return all;
}

}  // namespace pal_statistics
