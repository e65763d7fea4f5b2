#include "my_device.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/hardware/plugin.hpp"

namespace my_device_plugin {

using ctl::CallbackReturn;
using ctl::ReturnType;

/// Reads the parameters and names the interfaces. The order of the claims is the order of the indices below.
CallbackReturn MyDevice::on_configure(ctl::ControllerContext& context) {
  std::vector<std::string> joints;
  context.parameters.read("joints", joints, {"the joints, in the order of the values"});
  context.parameters.read("speed", speed_, {"of every joint, rad/s", true, 0.001, 10});
  for (const std::string& joint : joints) {
    const std::string whole = context.whole_joint(joint);
    claim_state(whole + "/position");
    claim_command(whole + "/position");
  }
  period_ = context.period;
  target_.assign(joints.size(), 0.0);
  commanded_.assign(joints.size(), 0.0);
  inbox_.reset(target_);
  on_parameters_changed();
  return joints.empty() ? CallbackReturn::failure : CallbackReturn::success;
}

CallbackReturn MyDevice::on_cleanup() {
  return CallbackReturn::success;
}
CallbackReturn MyDevice::on_error() {
  return CallbackReturn::success;  // it may be configured again
}

/// Begins at the last command where there is one, else where the joint is: becoming active never jumps.
CallbackReturn MyDevice::on_activate(const ctl::Cycle&) noexcept {
  inbox_.fetch();  // what was sent before is forgotten
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double last = command(i);
    target_[i] = commanded_[i] = std::isfinite(last) ? last : state(i);
    set_command(i, commanded_[i]);
  }
  standing_ = true;
  return CallbackReturn::success;
}

/// `verdict.speed` is the share of the speed that is allowed now; 0 asks to stop on the path.
ReturnType MyDevice::update(const ctl::Cycle&, const ctl::Verdict& verdict) noexcept {
  if (inbox_.fetch()) std::copy(inbox_.value().begin(), inbox_.value().end(), target_.begin());
  if (verdict.discard) target_ = commanded_;  // the same size: nothing is allocated
  const double step = verdict.immediate ? 0.0 : step_ * std::clamp(verdict.speed, 0.0, 1.0);
  standing_ = true;
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double left = target_[i] - commanded_[i];
    commanded_[i] += std::clamp(left, -step, step);
    if (step > 0 && commanded_[i] != target_[i]) standing_ = false;
    set_command(i, commanded_[i]);
  }
  return ReturnType::ok;
}

void MyDevice::on_deactivate(const ctl::Cycle&) noexcept {
  standing_ = true;
}

void MyDevice::on_parameters_changed() noexcept {
  step_ = speed_ * polyarm::seconds(period_);
}

/// Why these new values cannot be, for what a range alone does not say.
std::string MyDevice::refuse_changes(const std::vector<ctl::ParameterChange>&) const {
  return {};
}

std::vector<ctl::InputPort> MyDevice::inputs() const {
  return {{"commands", {"std_msgs/Float64MultiArray"}}};
}

std::uint64_t MyDevice::receive(const std::string&, const ctl::Input& message, bool) {
  const auto* numbers = std::get_if<ctl::Numbers>(&message);
  if (!numbers || numbers->values.size() != target_.size())
    throw polyarm::Error("wrong-message", "this controller takes " + std::to_string(target_.size()) +
                                              " numbers, one for each of its joints");
  inbox_.write(numbers->values);
  return 0;
}

}  // namespace my_device_plugin

POLYARM_PLUGIN("my_device", "0.1.0",
               POLYARM_CONTROLLER("my_vendor/MyDevice", my_device_plugin::MyDevice,
                                  "takes joints to positions at a steady speed"))
