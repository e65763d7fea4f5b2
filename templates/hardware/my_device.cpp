#include "my_device.hpp"

#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace my_device_plugin {

using hw::CallbackReturn;
using hw::ReturnType;

namespace {
/// A device that is not there: every joint stands where it was sent last.
class PretendedWire : public Wire {
 public:
  bool open(const std::string&, std::size_t joints) override {
    positions_.assign(joints, 0.0);
    return true;
  }
  void close() noexcept override {}
  bool enable(bool) noexcept override { return true; }
  bool read(std::size_t joint, double& position) noexcept override {
    position = positions_[joint];
    return true;
  }
  bool write(std::size_t joint, double position) noexcept override {
    positions_[joint] = position;
    return true;
  }

 private:
  std::vector<double> positions_;
};
}  // namespace

MyDevice::MyDevice() : MyDevice(std::make_unique<PretendedWire>()) {}
MyDevice::MyDevice(std::unique_ptr<Wire> wire) : wire_(std::move(wire)) {}

/// Takes over what the cell says and checks all of it; touches no device.
CallbackReturn MyDevice::on_init(const hw::ComponentContext& context) {
  polyarm::Problems problems;
  for (const auto& [key, value] : context.parameters)
    if (key == "port")
      port_ = value;
    else if (key != "following_error")  // that one is for the control loop
      problems.error("unknown-parameter", {}, context.name + " knows no parameter '" + key + "'",
                     "it has: port");
  for (const hw::RobotInstance& robot : context.robots)
    for (const auto& block : robot.hardware)
      for (const auto& component : block.components) {
        if (component.kind != "joint") continue;
        joints_.push_back(robot.name + "/" + component.name);
        for (const auto& interface : component.command_interfaces)
          if (interface.name != "position")
            problems.error("unknown-interface", interface.where,
                           component.name + " cannot be commanded by " + interface.name,
                           "this hardware takes positions");
      }
  if (joints_.empty())
    problems.error("no-joints", {}, "the <ros2_control> block of " + context.name + " names no joints");
  problems.throw_if_errors();
  return CallbackReturn::success;
}

/// Opens the device and makes sure that it is the right one. States are read from now on; nothing moves.
CallbackReturn MyDevice::on_configure() {
  if (!wire_->open(port_, joints_.size()) && note(Failure::no_device)) return CallbackReturn::failure;
  note(Failure::none);
  return CallbackReturn::success;
}

/// Enables the device where it stands: tell it to stay there first, then let it push.
CallbackReturn MyDevice::on_activate() {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    double here = 0;
    if (!wire_->read(i, here) && note(Failure::no_answer, i)) return CallbackReturn::failure;
    if (!wire_->write(i, here) && note(Failure::not_taken, i)) return CallbackReturn::failure;
  }
  if (!wire_->enable(true) && note(Failure::not_enabled)) return CallbackReturn::failure;
  return CallbackReturn::success;
}

/// Leaves it safe. Say in the README whether it holds or lets go: an arm without brakes falls when it lets
/// go.
CallbackReturn MyDevice::on_deactivate() {
  if (!wire_->enable(false) && note(Failure::not_enabled)) return CallbackReturn::error;
  return CallbackReturn::success;
}

CallbackReturn MyDevice::on_cleanup() {
  wire_->close();
  return CallbackReturn::success;
}

CallbackReturn MyDevice::on_shutdown() {
  wire_->close();
  return CallbackReturn::success;
}

/// After an error of read, write or a callback: make it safe. success: it may be configured again; error:
/// never.
CallbackReturn MyDevice::on_error() {
  wire_->enable(false);
  wire_->close();
  return CallbackReturn::success;
}

std::vector<hw::InterfaceDescription> MyDevice::state_interfaces() const {
  std::vector<hw::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({joint + "/position"});
  return out;
}

std::vector<hw::InterfaceDescription> MyDevice::command_interfaces() const {
  return state_interfaces();
}

/// May these commands be started and stopped together? For devices with modes, such as position and velocity.
ReturnType MyDevice::prepare_command_mode_switch(std::span<const std::string>, std::span<const std::string>) {
  return ReturnType::ok;
}
ReturnType MyDevice::perform_command_mode_switch(std::span<const std::string>,
                                                 std::span<const std::string>) noexcept {
  return ReturnType::ok;
}

ReturnType MyDevice::read(const hw::Cycle&, std::span<double> states) noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i)
    if (!wire_->read(i, states[i]) && note(Failure::no_answer, i)) return ReturnType::error;
  return ReturnType::ok;
}

ReturnType MyDevice::write(const hw::Cycle&, std::span<const double> commands) noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (!std::isfinite(commands[i])) continue;  // no command
    if (!wire_->write(i, commands[i]) && note(Failure::not_taken, i)) return ReturnType::error;
  }
  return ReturnType::ok;
}

/// Keeps why; always true.
bool MyDevice::note(Failure failure, std::size_t joint) noexcept {
  failed_joint_ = joint;
  failure_ = failure;
  return true;
}

std::string MyDevice::reason() const {
  const std::size_t at = failed_joint_;
  const std::string joint = at < joints_.size() ? joints_[at] : "the device";
  const std::string where = port_.empty() ? "" : " at " + port_;
  switch (failure_.load()) {
    case Failure::none:
      return {};
    case Failure::no_device:
      return "no device answers" + where + "; check cable, power and the parameter 'port'";
    case Failure::not_enabled:
      return "the device" + where + " could not be enabled or disabled; check its lamps";
    case Failure::no_answer:
      return joint + where + " does not answer; check its cable";
    case Failure::not_taken:
      return joint + where + " does not take commands; check its cable";
  }
  return {};
}

std::string MyDevice::summary() const {
  return "MyDevice with " + std::to_string(joints_.size()) + " joints, pretended";
}

}  // namespace my_device_plugin

POLYARM_PLUGIN("my_device", "0.1.0",
               POLYARM_HARDWARE("my_vendor/MyDevice", my_device_plugin::MyDevice,
                                "positions of any number of joints"))
