#pragma once
/// A goal that real-time code ends: it notes how, and runNonRealtime(), called by a timer, ends the goal.
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "polyarm_ros/standard.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp_action/server_goal_handle.hpp"
#include "realtime_tools/mutex.hpp"

namespace realtime_tools {

template <class Action>
class RealtimeServerGoalHandle {
  using Handle = rclcpp_action::ServerGoalHandle<Action>;
  using Result = typename Action::Result::SharedPtr;
  using Feedback = typename Action::Feedback::SharedPtr;
  enum class Wish { nothing, abort, cancel, succeed };

 public:
  explicit RealtimeServerGoalHandle(const std::shared_ptr<Handle>& handle, const Result& result = nullptr,
                                    const Feedback& feedback = nullptr,
                                    rclcpp::Logger = rclcpp::get_logger("realtime_tools"))
      : gh_(handle),
        preallocated_result_(result ? result : std::make_shared<typename Action::Result>()),
        preallocated_feedback_(feedback ? feedback : std::make_shared<typename Action::Feedback>()) {}

  std::shared_ptr<Handle> gh_;
  Result preallocated_result_;
  Feedback preallocated_feedback_;

  void setAborted(Result result = nullptr) { wish(Wish::abort, std::move(result)); }
  void setCanceled(Result result = nullptr) { wish(Wish::cancel, std::move(result)); }
  void setSucceeded(Result result = nullptr) { wish(Wish::succeed, std::move(result)); }
  bool setFeedback(Feedback feedback = nullptr) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock.owns_lock()) feedback_ = std::move(feedback);
    return lock.owns_lock();
  }
  void execute() { execute_ = true; }
  bool valid() const { return gh_ != nullptr; }
  void runNonRealtime() {
    if (!gh_) return;
    const std::lock_guard lock(mutex_);
    if (execute_ && gh_->is_active() && !gh_->is_canceling()) gh_->execute();
    const Wish wish = wish_;
    if (wish == Wish::abort && gh_->is_executing()) gh_->abort(result_);
    if (wish == Wish::cancel && gh_->is_active()) gh_->canceled(result_);
    if (wish == Wish::succeed && !gh_->is_canceling()) gh_->succeed(result_);
    if (feedback_ && gh_->is_executing()) gh_->publish_feedback(feedback_);
  }

 private:
  void wish(Wish wish, Result result) {
    if (!execute_ || wish_ != Wish::nothing) return;
    const std::lock_guard lock(mutex_);
    result_ = std::move(result);
    wish_ = wish;
  }
  std::atomic<bool> execute_{false};
  std::atomic<Wish> wish_{Wish::nothing};
  prio_inherit_mutex mutex_;
  Result result_;
  Feedback feedback_;
};

}  // namespace realtime_tools
