#pragma once
#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Publishes the states of the joints, as ros2_control's JointStateBroadcaster and ros_control's
/// JointStateController do. The output `joint_states` has three fields for each joint, in this order:
/// `<joint>/position`, `<joint>/velocity`, `<joint>/effort`; what hardware does not offer is NaN. Joints come
/// in the order of the description, whatever order hardware has. Output `dynamic_joint_states`: every state
/// interface that it reads, by name.
class JointStateBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

  /// As published: without their robot where the name is the only one of its kind.
  const std::vector<std::string>& joints() const { return joints_; }

 private:
  void add_joint(const ControllerContext& context, const std::string& whole, bool is_only_one);
  std::vector<std::string> joints_, wanted_;
  std::vector<std::string> renamed_{"position", "velocity", "effort"};
  struct Measured {
    std::uint32_t field, claimed, state;  // of the message; of claimed states; of the table
  };
  std::vector<Measured> measured_;
  std::vector<double> values_;  // of the fields that nobody measures
  Output* joint_states_ = nullptr;
  Output* dynamic_ = nullptr;
};

}  // namespace polyarm::controllers
