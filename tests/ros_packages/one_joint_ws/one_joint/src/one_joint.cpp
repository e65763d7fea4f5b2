#include <angles/angles/angles.h>
#include <builtin_interfaces/msg/duration.h>

#include <filters/filter_base.hpp>
#include <hardware_interface/system_interface.hpp>
#include <pluginlib/class_loader.hpp>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/std_msgs/msg/string.hpp>
#include <tf2_geometry_msgs/tf2_geometry_msgs.hpp>

#include "one_joint/bus.hpp"
#include "one_joint_clock/rate.h"
#include "one_joint_clock/ticks.hpp"
#include "one_joint_clock/units/second.hpp"
#if ONE_JOINT_TICKS != 12
#error "a header that a package makes and installs is not the one that it made"
#endif
#if RCPPUTILS_VERSION_MAJOR < 2
#error "a package that others need has no version"
#endif

namespace one_joint {
using hardware_interface::CallbackReturn;
using hardware_interface::return_type;

class OneJoint : public hardware_interface::SystemInterface {
 public:
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    out.emplace_back(info_.joints.at(0).name, "position", &position_);
    return out;
  }
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
    std::vector<hardware_interface::CommandInterface> out;
    out.emplace_back(info_.joints.at(0).name, "position", &command_);
    return out;
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    double half = 0;
    pluginlib::ClassLoader<filters::FilterBase<double>> loader("filters", "filters::FilterBase<double>");
    loader.createSharedInstance("one_joint_filters/Half")->update(3.0, half);
    geometry_msgs::msg::Point point;
    geometry_msgs::msg::TransformStamped up;
    up.transform.translation.z = half;
    tf2::doTransform(point, point, up);
    RCLCPP_INFO(rclcpp::get_logger("OneJoint"), "the note says %s at tick %d", note(point.z).value.c_str(),
                one_joint_clock::ticks());
    return CallbackReturn::SUCCESS;
  }
  return_type read(const rclcpp::Time&, const rclcpp::Duration&) override {
    position_ = command_;
    return return_type::OK;
  }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }

 private:
  double position_ = 0, command_ = 0;
};
}  // namespace one_joint

#include <pluginlib/class_list_macros.hpp>
PLUGINLIB_EXPORT_CLASS(one_joint::OneJoint, hardware_interface::SystemInterface)
