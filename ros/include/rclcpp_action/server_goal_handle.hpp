#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "polyarm_ros/wires.hpp"
#include "rclcpp/exceptions.hpp"
#include "rclcpp_action/types.hpp"

namespace rclcpp_action {

/// A goal that the wrapper of a controller has handed to a server. Any thread but the control loop's.
template <typename Action>
class ServerGoalHandle {
 public:
  using Goal = typename Action::Goal;
  using ResultPointer = std::shared_ptr<typename Action::Result>;
  using Ended = std::function<void(polyarm_ros::GoalEnd, const void*)>;

  ServerGoalHandle(const GoalUUID& id, std::shared_ptr<const Goal> goal, Ended ended)
      : id_(id), goal_(std::move(goal)), ended_(std::move(ended)) {}
  const std::shared_ptr<const Goal> get_goal() const { return goal_; }
  const GoalUUID& get_goal_id() const { return id_; }
  bool is_active() const { return state() != State::over; }
  bool is_executing() const { return state() == State::executing; }
  bool is_canceling() const { return state() == State::canceling; }
  void execute() {
    const std::lock_guard lock(mutex_);
    if (state_ == State::accepted) state_ = State::executing;
  }
  void succeed(ResultPointer result) { end(polyarm_ros::GoalEnd::succeeded, result); }
  void abort(ResultPointer result) { end(polyarm_ros::GoalEnd::aborted, result); }
  void canceled(ResultPointer result) { end(polyarm_ros::GoalEnd::canceled, result); }
  void publish_feedback(std::shared_ptr<typename Action::Feedback>) {}
  /// For the server: a client asks to cancel it.
  void polyarm_cancel() {
    const std::lock_guard lock(mutex_);
    if (state_ != State::over) state_ = State::canceling;
  }

 private:
  enum class State { accepted, executing, canceling, over };
  State state() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  void end(polyarm_ros::GoalEnd how, const ResultPointer& result) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(state_, State::over) == State::over) return;
    }
    const typename Action::Result none{};
    ended_(how, result ? result.get() : &none);
  }
  GoalUUID id_;
  std::shared_ptr<const Goal> goal_;
  Ended ended_;
  mutable std::mutex mutex_;
  State state_ = State::accepted;
};

}  // namespace rclcpp_action
