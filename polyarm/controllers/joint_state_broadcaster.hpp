#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// One joint state message: what sensor_msgs/JointState carries. Values that hardware does not offer are NaN.
struct JointStates {
  Nanoseconds time = 0;
  std::vector<double> position, velocity, effort;
};

/// Publishes the states of the joints, as ros2_control's JointStateBroadcaster does. Parameters: `joints`
/// (all of them by default), `interfaces` (position, velocity, effort by default; only those that exist are
/// claimed).
class JointStateBroadcaster : public Controller {
 public:
  /// `available` are the state interfaces of the table, so that only existing ones are asked for.
  explicit JointStateBroadcaster(std::vector<std::string> available) : available_(std::move(available)) {}
  CallbackReturn on_configure(const ControllerContext& context) override;
  std::vector<std::string> command_interfaces() const override { return {}; }
  std::vector<std::string> state_interfaces() const override { return names_; }
  CallbackReturn on_activate(const Cycle& cycle) noexcept override { return CallbackReturn::success; }
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

  const std::vector<std::string>& joints() const { return joints_; }
  /// The reader's end; for one other thread.
  realtime::Latest<JointStates>& outbox() noexcept { return outbox_; }

 private:
  std::vector<std::string> available_, joints_, names_;
  std::vector<std::array<int, 3>>
      places_;  // per joint: index into names_ of position, velocity, effort, or -1
  realtime::Latest<JointStates> outbox_;
};

}  // namespace polyarm::controllers
