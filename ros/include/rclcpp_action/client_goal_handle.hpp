#pragma once
#include <cstdint>
#include <functional>
#include <future>
#include <memory>

#include "rclcpp/macros.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp_action/types.hpp"

namespace rclcpp_action {

enum class ResultCode : std::int8_t { UNKNOWN = 0, SUCCEEDED = 4, CANCELED = 5, ABORTED = 6 };

/// A goal that a client has sent. Nobody offers actions to plugins: there is none.
template <typename Action>
class ClientGoalHandle {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ClientGoalHandle<Action>)
  struct WrappedResult {
    GoalUUID goal_id{};
    ResultCode code = ResultCode::UNKNOWN;
    typename Action::Result::SharedPtr result;
  };
  using Feedback = typename Action::Feedback;
  using Result = typename Action::Result;
  using FeedbackCallback = std::function<void(SharedPtr, const std::shared_ptr<const Feedback>)>;
  using ResultCallback = std::function<void(const WrappedResult&)>;
  const GoalUUID& get_goal_id() const { return id_; }
  std::int8_t get_status() { return 0; }
  bool is_feedback_aware() { return false; }
  bool is_result_aware() { return false; }
  std::shared_future<WrappedResult> async_get_result() { return std::promise<WrappedResult>().get_future().share(); }

 private:
  GoalUUID id_{};
};

}  // namespace rclcpp_action
