// As in the first releases of ROS 2 Foxy: no BaseInterface, no life cycle, no time in read and write.
#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "hardware_interface/system_interface.hpp"
#include "hardware_interface/types/hardware_interface_status_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/rclcpp.hpp"

namespace early_joint {
using hardware_interface::return_type;

class EarlyJoint : public hardware_interface::SystemInterface {
 public:
  return_type configure(const hardware_interface::HardwareInfo& info) override {
    name_ = info.joints.at(0).name;
    status_ = hardware_interface::status::CONFIGURED;
    return return_type::OK;
  }
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    out.emplace_back(name_, "position", &position_);
    return out;
  }
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
    std::vector<hardware_interface::CommandInterface> out;
    out.emplace_back(name_, "position", &command_);
    return out;
  }
  return_type start() override {
    RCLCPP_INFO(rclcpp::get_logger("early"), "%s has started", name_.c_str());
    status_ = hardware_interface::status::STARTED;
    return return_type::OK;
  }
  return_type stop() override {
    status_ = hardware_interface::status::STOPPED;
    return return_type::OK;
  }
  std::string get_name() const override { return "early"; }
  hardware_interface::status get_status() const override { return status_; }
  return_type read() override {
    position_ = command_;
    return return_type::OK;
  }
  return_type write() override { return return_type::OK; }

 private:
  std::string name_;
  hardware_interface::status status_ = hardware_interface::status::UNKNOWN;
  double position_ = 0, command_ = 0;
};

}  // namespace early_joint

PLUGINLIB_EXPORT_CLASS(early_joint::EarlyJoint, hardware_interface::SystemInterface)
