#pragma once
/// Topics between the nodes of one module, and to the ROS 2 graph (graph.hpp). A publisher hands a copy of
/// its message to each subscription of its topic and type; the node's executor calls them. A topic without
/// subscriptions costs two looks at a number.
#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "polyarm_ros/cell_clock.hpp"
#include "polyarm_ros/graph.hpp"

namespace polyarm_ros {

/// "commands", "~/commands" or "/commands" of a node as "/space/node/commands".
inline std::string full_topic(const std::string& space, const std::string& node, const std::string& topic) {
  const auto below = [](const std::string& front, const std::string& rest) {
    return front.empty() || front.back() == '/' ? front + rest : front + "/" + rest;
  };
  if (!topic.empty() && topic[0] == '/') return topic;
  if (topic == "~") return node;
  if (topic.compare(0, 2, "~/") == 0) return below(node, topic.substr(2));
  return below(space, topic);
}

struct Listener;

class Topic {
 public:
  std::atomic<int> listeners{0}, speakers{0};

  void add(const std::shared_ptr<Listener>& listener) {
    const std::lock_guard lock(mutex_);
    all_.push_back(listener);
  }
  template <typename Message>
  void send(const Message& message);
  /// A message of the type `type` ("std_msgs/msg/String") that its sender knows as bytes only.
  void send_bytes(const std::string& type, const Payload& payload);

 private:
  std::vector<std::shared_ptr<Listener>> alive();
  std::mutex mutex_;
  std::vector<std::weak_ptr<Listener>> all_;
};
inline std::shared_ptr<Topic> find_topic(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Topic>> all;
  const std::lock_guard lock(mutex);
  std::weak_ptr<Topic>& place = all[name];
  auto out = place.lock();
  if (!out) place = out = std::make_shared<Topic>();
  return out;
}

/// A subscription. `deliver` gets a message of type `type`; it copies it. One whose node knows the message as
/// bytes only has the type Payload.
struct Listener {
  Listener(std::string name, const std::type_info* of_type, std::function<void(const void*)> call,
           std::shared_ptr<Topic> on, std::size_t keep)
      : topic(std::move(name)), type(of_type), deliver(std::move(call)), on_(std::move(on)), keep_(keep ? keep : 1) {
    ++on_->listeners;
  }
  ~Listener() { --on_->listeners; }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void take(std::shared_ptr<const void> message) {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= keep_) waiting_.pop_front();
    waiting_.push_back(std::move(message));
  }
  std::shared_ptr<const void> next() {
    pull();
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return nullptr;
    auto out = std::move(waiting_.front());
    waiting_.pop_front();
    return out;
  }
  bool has_message() {
    pull();
    const std::lock_guard lock(mutex_);
    return !waiting_.empty();
  }
  /// Delivers what was waiting at the call, until the steady time `until` (ns; 0: all); false if nothing was.
  bool run(std::int64_t until = 0) {
    pull();
    std::size_t left = 0;
    {
      const std::lock_guard lock(mutex_);
      left = waiting_.size();
    }
    bool any = false;
    for (; left > 0; --left) {
      if (any && until > 0 && steady_time() >= until) break;
      if (const auto message = next()) deliver(message.get()), any = true;
    }
    return any;
  }
  int publishers() const { return on_->speakers; }

  const std::string topic;
  const std::type_info* const type;
  const std::function<void(const void*)> deliver;
  std::string type_name;  ///< "std_msgs/msg/String"; empty for messages without a definition
  std::function<std::shared_ptr<const void>(const Payload&)> from_bytes;  ///< null: not read from bytes
  Port port;  ///< null if nothing comes from the graph
  std::function<std::shared_ptr<const void>(polyarm::hardware::NodePort&)> take_from_port;

 private:
  void pull() {
    if (!port || !take_from_port) return;
    for (std::size_t n = 0; n < polyarm::hardware::LetterQueue::kMost; ++n) {  // others go on sending
      auto message = take_from_port(*port);
      if (!message) break;
      take(std::move(message));
    }
  }
  std::shared_ptr<Topic> on_;
  std::size_t keep_;
  std::mutex mutex_;
  std::deque<std::shared_ptr<const void>> waiting_;
};

/// A publisher. `take` is called with each message by the thread that publishes it.
struct Speaker {
  Speaker(std::string name, const std::type_info* of_type, std::shared_ptr<Topic> on)
      : topic(std::move(name)), type(of_type), on(std::move(on)) {
    ++this->on->speakers;
  }
  ~Speaker() { --on->speakers; }
  Speaker(const Speaker&) = delete;
  Speaker& operator=(const Speaker&) = delete;

  const std::string topic;
  const std::type_info* const type;
  std::function<void(const void*)> take;
  Port port;  ///< null if nothing goes to the graph
  const std::shared_ptr<Topic> on;
};

inline std::vector<std::shared_ptr<Listener>> Topic::alive() {
  std::vector<std::shared_ptr<Listener>> out;
  const std::lock_guard lock(mutex_);
  for (auto at = all_.begin(); at != all_.end();) {
    auto listener = at->lock();
    at = listener ? at + 1 : all_.erase(at);
    if (listener) out.push_back(std::move(listener));
  }
  return out;
}
template <typename Message>
void Topic::send(const Message& message) {
  if (listeners == 0) return;
  for (const auto& listener : alive()) {
    if (*listener->type == typeid(Message)) {
      listener->take(std::make_shared<const Message>(message));
    } else if constexpr (HasFields<Message>::value) {
      if (*listener->type != typeid(Payload) || listener->type_name != Message::polyarm_type()) continue;
      auto payload = std::make_shared<Payload>();
      encode(message, *payload);
      listener->take(std::move(payload));
    }
  }
}
inline void Topic::send_bytes(const std::string& type, const Payload& payload) {
  if (listeners == 0) return;
  for (const auto& listener : alive()) {
    if (listener->type_name != type) continue;
    if (*listener->type == typeid(Payload))
      listener->take(std::make_shared<const Payload>(payload));
    else if (auto message = listener->from_bytes ? listener->from_bytes(payload) : nullptr)
      listener->take(std::move(message));
  }
}

}  // namespace polyarm_ros
