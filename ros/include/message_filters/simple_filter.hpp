#pragma once
/// Something that gives messages to callbacks. Any thread; callbacks run in the thread that brings the
/// message.
#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "message_filters/connection.hpp"
#include "message_filters/message_event.hpp"

namespace message_filters {

template <typename M>
class SimpleFilter {
 public:
  using MConstPtr = std::shared_ptr<const M>;
  using EventType = MessageEvent<const M>;
  using EventCallback = std::function<void(const EventType&)>;
  SimpleFilter() = default;
  virtual ~SimpleFilter() = default;
  SimpleFilter(const SimpleFilter&) = delete;
  SimpleFilter& operator=(const SimpleFilter&) = delete;

  template <typename Callback>
  Connection registerCallback(const Callback& call) {
    if constexpr (std::is_invocable_v<const Callback&, const MConstPtr&>)
      return add([call](const EventType& e) { call(e.getConstMessage()); });
    else if constexpr (std::is_invocable_v<const Callback&, const EventType&>)
      return add(call);
    else if constexpr (std::is_invocable_v<const Callback&, const M&>)
      return add([call](const EventType& e) { call(*e.getConstMessage()); });
    else
      return add([call](const EventType& e) { call(std::make_shared<M>(*e.getConstMessage())); });
  }
  template <typename T, typename P>
  Connection registerCallback(void (T::*call)(P), T* of) {
    return registerCallback([call, of](const MConstPtr& m) {
      if constexpr (std::is_convertible_v<MConstPtr, P>)
        (of->*call)(m);
      else
        (of->*call)(*m);
    });
  }
  void setName(const std::string& name) { name_ = name; }
  const std::string& getName() const { return name_; }

 protected:
  void signalMessage(const MConstPtr& message) { signalMessage(EventType(message)); }
  void signalMessage(const EventType& event) {
    std::vector<std::shared_ptr<EventCallback>> all;
    {
      const std::lock_guard lock(*mutex_);
      all = *callbacks_;
    }
    for (const auto& each : all) (*each)(event);
  }

 private:
  using All = std::vector<std::shared_ptr<EventCallback>>;
  Connection add(EventCallback call) {
    auto made = std::make_shared<EventCallback>(std::move(call));
    const std::lock_guard lock(*mutex_);
    callbacks_->push_back(made);
    return Connection([all = std::weak_ptr<All>(callbacks_), mutex = mutex_, made] {
      const std::lock_guard guard(*mutex);
      if (const auto here = all.lock())
        here->erase(std::remove(here->begin(), here->end(), made), here->end());
    });
  }
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();
  std::shared_ptr<All> callbacks_ = std::make_shared<All>();
  std::string name_;
};

}  // namespace message_filters
