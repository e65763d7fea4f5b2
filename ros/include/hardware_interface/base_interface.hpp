#pragma once
/// The life cycle of Foxy, on the one of today: configure is on_init, start on_activate, stop on_deactivate.
#include "hardware_interface/hardware_component_interface.hpp"

namespace hardware_interface {

template <class Interface>
class BaseInterface : public Interface {
 public:
  virtual return_type configure(const HardwareInfo& info) { return configure_default(info); }
  return_type configure_default(const HardwareInfo& info) {
    this->info_ = info;
    status_ = status::CONFIGURED;
    return return_type::OK;
  }
  virtual return_type start() { return return_type::OK; }
  virtual return_type stop() { return return_type::OK; }
  std::string get_name() const override { return this->info_.name; }
  virtual status get_status() const { return status_; }

  CallbackReturn on_init(const HardwareInfo& info) override {
    Interface::on_init(info);
    return configure(info) == return_type::OK ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }
  using Interface::on_init;
  CallbackReturn on_activate(const rclcpp_lifecycle::State&) override {
    return start() == return_type::OK ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }
  CallbackReturn on_deactivate(const rclcpp_lifecycle::State&) override {
    return stop() == return_type::OK ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }

 protected:
  status status_ = status::UNKNOWN;
};

}  // namespace hardware_interface
