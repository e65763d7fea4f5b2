#pragma once
/// Where the topics and actions of a controller's node end: the wrapper of the controller delivers messages
/// to its subscriptions, takes what it publishes, and hands goals to its action servers. Other topics and
/// services lead to nodes of the module and to the ROS 2 graph (topics.hpp); other actions lead nowhere.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <typeinfo>
#include <vector>

#include "polyarm_ros/topics.hpp"

namespace polyarm_ros {

enum class GoalEnd : std::uint8_t { succeeded, aborted, canceled };
/// An action server. `goal` gets a goal message of type `type`, the number that its client knows it by, and
/// what to call when it ends, with the result; false if the server rejects it. `cancel` is false if the goal
/// is not under way, or is not to be canceled.
struct ActionPort {
  using Ended = std::function<void(std::uint64_t, GoalEnd, const void* result)>;
  std::string name;
  const std::type_info* type;
  std::function<bool(const void*, std::uint64_t, Ended)> goal;
  std::function<bool(std::uint64_t)> cancel;
};

/// A service or client of a node. Its callbacks run in `run`, until the steady time `until` (ns; 0: for all
/// that waits); false if nothing waited.
struct Callee {
  virtual ~Callee() = default;
  virtual bool run(std::int64_t until) = 0;
  virtual std::string title() const = 0;
};

/// True while the cell thread, which serves the graph, or the control thread calls the plugin: there, waiting
/// for the graph is in vain.
inline bool& serves_graph() {
  static thread_local bool value = false;
  return value;
}
struct ServesGraph {
  ServesGraph() : before_(serves_graph()) { serves_graph() = true; }
  ~ServesGraph() { serves_graph() = before_; }
  ServesGraph(const ServesGraph&) = delete;
  ServesGraph& operator=(const ServesGraph&) = delete;

 private:
  const bool before_;
};

/// Of one node. Any thread.
class Wires {
 public:
  /// Set by the wrapper, before the controller names topics: they lead somewhere.
  bool open = false;

  void add(const std::shared_ptr<Listener>& each) { add_to(listeners_, each); }
  void add(const std::shared_ptr<Speaker>& each) { add_to(speakers_, each); }
  void add(const std::shared_ptr<ActionPort>& each) { add_to(actions_, each); }
  void add(const std::shared_ptr<Callee>& each) { add_to(callees_, each); }
  std::vector<std::shared_ptr<Listener>> listeners() const { return alive(listeners_); }
  std::vector<std::shared_ptr<Speaker>> speakers() const { return alive(speakers_); }
  std::vector<std::shared_ptr<ActionPort>> actions() const { return alive(actions_); }
  std::vector<std::shared_ptr<Callee>> callees() const { return alive(callees_); }

 private:
  template <typename T>
  void add_to(std::vector<std::weak_ptr<T>>& all, const std::shared_ptr<T>& each) {
    const std::lock_guard lock(mutex_);
    const auto ended = [](const std::weak_ptr<T>& old) { return old.expired(); };
    all.erase(std::remove_if(all.begin(), all.end(), ended), all.end());
    all.push_back(each);
  }
  template <typename T>
  std::vector<std::shared_ptr<T>> alive(const std::vector<std::weak_ptr<T>>& all) const {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<T>> out;
    for (const auto& each : all)
      if (auto found = each.lock()) out.push_back(std::move(found));
    return out;
  }
  mutable std::mutex mutex_;
  std::vector<std::weak_ptr<Listener>> listeners_;
  std::vector<std::weak_ptr<Speaker>> speakers_;
  std::vector<std::weak_ptr<ActionPort>> actions_;
  std::vector<std::weak_ptr<Callee>> callees_;
};

}  // namespace polyarm_ros
