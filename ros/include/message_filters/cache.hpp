#pragma once
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "message_filters/message_traits.hpp"
#include "message_filters/simple_filter.hpp"

namespace message_filters {
/// The last messages, in the order of their stamps.
template <typename M>
class Cache : public SimpleFilter<M> {
 public:
  using typename SimpleFilter<M>::EventType;
  using typename SimpleFilter<M>::MConstPtr;
  explicit Cache(unsigned int size = 1) { setCacheSize(size); }
  template <typename Filter>
  explicit Cache(Filter& from, unsigned int size = 1) {
    setCacheSize(size);
    connectInput(from);
  }
  ~Cache() override { input_.disconnect(); }
  template <typename Filter>
  void connectInput(Filter& from) {
    input_.disconnect();
    input_ = from.registerCallback([this](const EventType& event) { add(event); });
  }
  /// Drops the oldest messages that no longer fit. 0 counts as 1.
  void setCacheSize(unsigned int size) {
    const std::lock_guard lock(mutex_);
    size_ = size ? size : 1;
    while (all_.size() > size_) all_.pop_front();
  }
  void add(const MConstPtr& message) { add(EventType(message)); }
  void add(const EventType& event) {
    {
      const std::lock_guard lock(mutex_);
      auto at = all_.end();
      while (at != all_.begin() && stamp(*(at - 1)) > stamp(event)) --at;
      all_.insert(at, event);
      if (all_.size() > size_) all_.pop_front();
    }
    this->signalMessage(event);
  }
  std::vector<MConstPtr> getInterval(const rclcpp::Time& begin, const rclcpp::Time& end) const {
    const std::lock_guard lock(mutex_);
    std::vector<MConstPtr> out;
    for (const EventType& e : all_)
      if (stamp(e) >= begin && stamp(e) <= end) out.push_back(e.getConstMessage());
    return out;
  }
  MConstPtr getElemBeforeTime(const rclcpp::Time& time) const {
    const std::lock_guard lock(mutex_);
    MConstPtr out;
    for (const EventType& e : all_)
      if (stamp(e) <= time) out = e.getConstMessage();
    return out;
  }
  MConstPtr getElemAfterTime(const rclcpp::Time& time) const {
    const std::lock_guard lock(mutex_);
    for (const EventType& e : all_)
      if (stamp(e) >= time) return e.getConstMessage();
    return nullptr;
  }
  std::vector<MConstPtr> getSurroundingInterval(const rclcpp::Time& begin, const rclcpp::Time& end) const {
    const std::lock_guard lock(mutex_);
    std::vector<MConstPtr> out;
    for (const EventType& e : all_) {
      if (stamp(e) <= begin) out.clear();
      out.push_back(e.getConstMessage());
      if (stamp(e) >= end) break;
    }
    return out;
  }
  rclcpp::Time getLatestTime() const {
    const std::lock_guard lock(mutex_);
    return all_.empty() ? rclcpp::Time(0, 0, RCL_ROS_TIME) : stamp(all_.back());
  }
  rclcpp::Time getOldestTime() const {
    const std::lock_guard lock(mutex_);
    return all_.empty() ? rclcpp::Time(0, 0, RCL_ROS_TIME) : stamp(all_.front());
  }

 private:
  static rclcpp::Time stamp(const EventType& e) {
    return message_traits::TimeStamp<M>::value(*e.getConstMessage());
  }
  mutable std::mutex mutex_;
  std::deque<EventType> all_;
  std::size_t size_ = 1;
  Connection input_;
};
}  // namespace message_filters
