#include "drivers/cia402/component.hpp"

#include <fmt/format.h>

namespace polyarm::cia402 {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {
constexpr const char* kControllerStates[] = {"ready", "limited", "warned", "lost"};
}

CallbackReturn Cia402Component::on_init(const hardware::ComponentContext& context) {
  period_ = context.period;
  settings_ = read_settings(context);
  settings_.watchdog = watchdog_;
  paced_ = settings_.pace;
  steps_ = wire::StepCheckOf<kMostDrives>(settings_.max_step);
  robot_ = context.robots.front().name;
  joints_.clear();
  for (const JointSettings& joint : settings_.joints) joints_.push_back(joint.name);
  link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

CallbackReturn Cia402Component::on_shutdown() {
  active_ = false;
  if (link_) link_->shut_down();
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> Cia402Component::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/effort"}) out.push_back({robot_ + "/" + joint + one});
  for (const char* one : kControllerStates) out.push_back({robot_ + "/controller/" + one});
  return out;
}

std::vector<hardware::InterfaceDescription> Cia402Component::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  return out;
}

ReturnType Cia402Component::read(const hardware::Cycle&, std::span<double> states) noexcept {
  link_->fetch();
  const Sample& sample = link_->sample();
  std::size_t at = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    for (const double value : {sample.q[j], sample.dq[j], sample.effort[j]}) states[at++] = value;
  const bool ready = sample.enabled == (1U << joints_.size()) - 1;
  for (const double value : {ready ? 1.0 : 0.0, static_cast<double>(sample.limited),
                             static_cast<double>(sample.warned), static_cast<double>(sample.lost)})
    states[at++] = value;
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType Cia402Component::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (link_->cause() != Cause::none) return ReturnType::error;
  return active_ ? write_joints(commands, joints_.size()) : ReturnType::ok;
}

const hardware::DriverFacts* Cia402Component::facts() const noexcept {
  return &cia402::facts();
}

std::string Cia402Component::summary() const {
  if (!link_) return {};
  return fmt::format("{} CiA 402 drives on {}, positions at {:g} Hz, {:.0f} % of the bus{}", joints_.size(),
                     settings_.bus.bus, link_->rate(),
                     100 * bus_load(joints_.size(), settings_.bus.bit_rate, settings_.cycle),
                     link_->needs_watchdog() ? ", with a watchdog process" : "");
}

}  // namespace polyarm::cia402
