#pragma once
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "rclcpp/macros.hpp"
#include "rclcpp_action/server_goal_handle.hpp"

namespace rclcpp_action {

class ServerBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ServerBase)
  virtual ~ServerBase() = default;
};

/// Gets goals from the wrapper of a controller; without one, none.
template <typename Action>
class Server : public ServerBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Server<Action>)
  using Handle = ServerGoalHandle<Action>;
  using GoalCallback =
      std::function<GoalResponse(const GoalUUID&, std::shared_ptr<const typename Action::Goal>)>;
  using CancelCallback = std::function<CancelResponse(std::shared_ptr<Handle>)>;
  using AcceptedCallback = std::function<void(std::shared_ptr<Handle>)>;

  Server(const std::string& name, GoalCallback goal, CancelCallback cancel, AcceptedCallback accepted)
      : goal_(std::move(goal)), cancel_(std::move(cancel)), accepted_(std::move(accepted)) {
    port_ = std::make_shared<polyarm_ros::ActionPort>();
    port_->name = name;
    port_->type = &typeid(typename Action::Goal);
    port_->goal = [this](const void* message, std::uint64_t number, polyarm_ros::ActionPort::Ended ended) {
      return take(*static_cast<const typename Action::Goal*>(message), number, std::move(ended));
    };
    port_->cancel = [this](std::uint64_t number) { return end(number); };
  }
  const std::shared_ptr<polyarm_ros::ActionPort>& polyarm_port() const { return port_; }

 private:
  bool take(const typename Action::Goal& message, std::uint64_t number,
            polyarm_ros::ActionPort::Ended ended) {
    GoalUUID id{};
    std::memcpy(id.data(), &number, sizeof number);
    auto goal = std::make_shared<const typename Action::Goal>(message);
    const GoalResponse response = goal_(id, goal);
    if (response == GoalResponse::REJECT) return false;
    auto handle = std::make_shared<Handle>(
        id, goal, [number, ended](polyarm_ros::GoalEnd how, const void* result) { ended(number, how, result); });
    for (auto at = active_.begin(); at != active_.end();)
      at = at->second->is_active() ? std::next(at) : active_.erase(at);
    active_[number] = handle;
    if (response == GoalResponse::ACCEPT_AND_EXECUTE) handle->execute();
    accepted_(handle);
    return true;
  }
  bool end(std::uint64_t number) {
    const auto found = active_.find(number);
    if (found == active_.end() || !found->second->is_active()) return false;
    const std::shared_ptr<Handle> handle = found->second;
    if (cancel_(handle) != CancelResponse::ACCEPT) return false;
    handle->polyarm_cancel();
    return true;
  }
  GoalCallback goal_;
  CancelCallback cancel_;
  AcceptedCallback accepted_;
  std::shared_ptr<polyarm_ros::ActionPort> port_;
  std::map<std::uint64_t, std::shared_ptr<Handle>> active_;
};

}  // namespace rclcpp_action
