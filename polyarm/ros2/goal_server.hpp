#pragma once
/// The goals of one ROS 2 action: its three services, feedback and status. Its owner decides what a goal
/// does. Cell thread.
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

using messages::action_msgs::msg::GoalStatus;

struct Goal {
  Json id;  ///< {"uuid": […]}
  Json stamp;
  int status = GoalStatus::STATUS_UNKNOWN;
  std::uint64_t number = 0;  ///< the cell's number of the goal, once it is accepted
  Json result = Json::object();
  std::vector<Reply> waiting;  ///< clients that wait for the result
  Nanoseconds ended = 0;
  bool over() const { return status >= GoalStatus::STATUS_SUCCEEDED; }
};
using GoalPointer = std::shared_ptr<Goal>;

class GoalServer : public std::enable_shared_from_this<GoalServer> {
 public:
  /// `take`: called with each new goal and its message; it calls accept() or refuse(), perhaps later.
  /// `cancel`: called once for a goal that a client cancels; its owner ends the goal when it has stopped.
  struct Owner {
    std::function<void(const GoalPointer& goal, Json message, Reply reply)> take;
    std::function<void(const GoalPointer& goal)> cancel;
  };
  GoalServer(Bridge& bridge, std::string node, std::string name, std::string type)
      : bridge_{bridge}, node_{std::move(node)}, name_{std::move(name)}, type_{std::move(type)} {}

  void begin(Owner owner);
  /// Call each tick.
  void serve();
  /// The owner is gone: nothing is taken and cancelled any more.
  void close() { owner_ = {}; }

  void accept(const GoalPointer& goal, const Reply& reply);
  void refuse(const GoalPointer& goal, const Reply& reply) const;
  void end(const GoalPointer& goal, int status, Json result);
  void tell_feedback(const Goal& goal, Json feedback);
  /// True for the goal that was accepted last.
  bool is_newest(const Goal& goal) const { return !goals_.empty() && goals_.back().get() == &goal; }

 private:
  void forget_old();
  GoalPointer find(const Json& id) const;
  void send_goal(Json request, Reply reply);
  void get_result(const Json& request, Reply reply);
  void cancel_goal(Json request, const Reply& reply);
  void report_status();

  Bridge& bridge_;
  const std::string node_, name_, type_;
  Owner owner_;
  const messages::TypeInfo* feedback_type_ = nullptr;
  std::chrono::steady_clock::time_point told_feedback_;
  Wire::Id feedback_ = 0, status_ = 0;
  std::deque<GoalPointer> goals_;
  std::optional<Nanoseconds> accepted_;  ///< time of the last accepted goal, until its status has been sent
                                         ///< again
};

}  // namespace polyarm::ros2
