#pragma once
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "polyarm_ros/door.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp_action/client_goal_handle.hpp"

namespace rclcpp_action {

class ClientBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ClientBase)
  ClientBase(const std::string& node, std::string name) : name_(std::move(name)) {
    polyarm_ros::report_unavailable(node, "action", name_);
  }
  virtual ~ClientBase() = default;
  bool action_server_is_ready() const { return false; }
  template <typename Rep = long, typename Ratio = std::milli>
  bool wait_for_action_server(std::chrono::duration<Rep, Ratio> = std::chrono::duration<Rep, Ratio>(-1)) {
    return false;
  }

 private:
  std::string name_;
};

/// Of an action that nobody offers: its goals are never accepted. The future of a goal does not become ready
/// before the next goal or the end of the client, which break its promise: get() throws std::future_error
/// then.
template <typename Action>
class Client : public ClientBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Client<Action>)
  using ClientBase::ClientBase;
  using Goal = typename Action::Goal;
  using GoalHandle = ClientGoalHandle<Action>;
  using WrappedResult = typename GoalHandle::WrappedResult;
  using GoalResponseCallback = std::function<void(typename GoalHandle::SharedPtr)>;
  struct SendGoalOptions {
    GoalResponseCallback goal_response_callback;
    typename GoalHandle::FeedbackCallback feedback_callback;
    typename GoalHandle::ResultCallback result_callback;
  };
  std::shared_future<typename GoalHandle::SharedPtr> async_send_goal(const Goal&, const SendGoalOptions& = {}) {
    goal_ = {};
    return goal_.get_future().share();
  }
  template <typename... Rest>
  std::shared_future<WrappedResult> async_get_result(Rest&&...) {
    result_ = {};
    return result_.get_future().share();
  }
  template <typename... Rest>
  std::shared_future<bool> async_cancel_goal(Rest&&...) {
    canceled_ = {};
    return canceled_.get_future().share();
  }
  template <typename... Rest>
  std::shared_future<bool> async_cancel_all_goals(Rest&&...) {
    return async_cancel_goal();
  }

 private:
  std::promise<typename GoalHandle::SharedPtr> goal_;
  std::promise<WrappedResult> result_;
  std::promise<bool> canceled_;
};

template <typename Action, typename NodePointer, typename... Rest>
typename Client<Action>::SharedPtr create_client(const NodePointer& node, const std::string& name, Rest&&...) {
  return std::make_shared<Client<Action>>(node->get_name(), name);
}

}  // namespace rclcpp_action
