#pragma once
/// Small hardware and a small controller for the plugins that the tests load.
#include <chrono>
#include <stdexcept>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace things {

namespace hw = polyarm::hardware;
namespace ctl = polyarm::controllers;

/// Every joint of the robot stands where it was told to; throws in the callback that `throws` names.
class Follower : public hw::Component {
 public:
  hw::CallbackReturn on_init(const hw::ComponentContext& context) override {
    if (const auto found = context.parameters.find("throws"); found != context.parameters.end())
      throws_ = found->second;
    slow_ = context.parameters.contains("slow");
    trip("on_init");
    for (const hw::RobotInstance& robot : context.robots)
      for (const int joint : robot.model->actuated)
        names_.push_back(robot.name + "/" + robot.model->joints[static_cast<std::size_t>(joint)].name +
                         "/position");
    at_.assign(names_.size(), 0.25);
    return hw::CallbackReturn::success;
  }
  hw::CallbackReturn on_configure() override { return trip("on_configure"); }
  hw::CallbackReturn on_activate() override { return trip("on_activate"); }
  hw::CallbackReturn on_deactivate() override { return trip("on_deactivate"); }
  hw::CallbackReturn on_cleanup() override { return trip("on_cleanup"); }
  hw::CallbackReturn on_shutdown() override { return trip("on_shutdown"); }
  hw::CallbackReturn on_error() override { return trip("on_error"); }

  std::vector<hw::InterfaceDescription> state_interfaces() const override { return described(); }
  std::vector<hw::InterfaceDescription> command_interfaces() const override { return described(); }
  hw::ReturnType read(const hw::Cycle&, std::span<double> states) noexcept override {
    using Clock = std::chrono::steady_clock;
    if (slow_)  // longer than any budget of a test, by the clock that it is measured with
      for (const auto end = Clock::now() + std::chrono::microseconds(20); Clock::now() < end;) {
      }
    for (std::size_t i = 0; i < at_.size(); ++i) states[i] = at_[i];
    return hw::ReturnType::ok;
  }
  hw::ReturnType write(const hw::Cycle&, std::span<const double> commands) noexcept override {
    for (std::size_t i = 0; i < at_.size(); ++i)
      if (commands[i] == commands[i]) at_[i] = commands[i];
    return hw::ReturnType::ok;
  }

 private:
  hw::CallbackReturn trip(const std::string& callback) {
    if (throws_ == callback) throw std::runtime_error("tripped in " + callback);
    return hw::CallbackReturn::success;
  }
  std::vector<hw::InterfaceDescription> described() const {
    std::vector<hw::InterfaceDescription> out;
    for (const std::string& name : names_) out.push_back({name, 0.25});
    return out;
  }
  std::string throws_;
  bool slow_ = false;
  std::vector<std::string> names_;
  std::vector<double> at_;
};

/// Commands one joint to `position`; throws where `throws` says.
class Holder : public ctl::Controller {
 public:
  hw::CallbackReturn on_configure(ctl::ControllerContext& context) override {
    std::string joint, throws;
    context.parameters.read("joint", joint, {"the joint that is held"});
    context.parameters.read("position", position_, {"rad", true});
    context.parameters.read("throws", throws, {"the callback that throws"});
    throws_cleanup_ = throws == "on_cleanup";
    if (throws == "on_configure") throw 42;  // no std::exception at all
    command_ = claim_command(context.whole_joint(joint, "joint") + "/position");
    return hw::CallbackReturn::success;
  }
  hw::CallbackReturn on_cleanup() override {
    if (throws_cleanup_) throw std::runtime_error("tripped in on_cleanup");
    return hw::CallbackReturn::success;
  }
  hw::ReturnType update(const hw::Cycle&, const ctl::Verdict&) noexcept override {
    set_command(command_, position_);
    return hw::ReturnType::ok;
  }

 private:
  double position_ = 0.5;
  bool throws_cleanup_ = false;
  std::size_t command_ = 0;
};

}  // namespace things
