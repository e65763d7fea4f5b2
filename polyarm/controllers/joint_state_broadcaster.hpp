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
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

  /// As published: without their robot where the name is the only one of its kind.
  const std::vector<std::string>& joints() const { return joints_; }

 private:
  void add_joint(const ControllerContext& context, const std::string& whole);
  std::vector<std::string> joints_, wanted_;
  std::vector<std::string> renamed_{"position", "velocity", "effort"};
  std::vector<int> places_;  // index of the state behind each field, or -1
  std::vector<double> fixed_;
  Output* joint_states_ = nullptr;
  Output* dynamic_ = nullptr;
};

}  // namespace polyarm::controllers
