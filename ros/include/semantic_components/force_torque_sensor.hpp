#pragma once
#include "geometry_msgs/msg/wrench.hpp"
#include "semantic_components/semantic_component_interface.hpp"

namespace semantic_components {

class ForceTorqueSensor : public SemanticComponentInterface<geometry_msgs::msg::Wrench> {
 public:
  explicit ForceTorqueSensor(const std::string& name)
      : SemanticComponentInterface(
            name, named(name, {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"})) {
    existing_axes_.fill(true);
    data_.fill(std::numeric_limits<double>::quiet_NaN());
  }
  /// An axis without a name stays NaN.
  ForceTorqueSensor(const std::string& fx, const std::string& fy, const std::string& fz,
                    const std::string& tx, const std::string& ty, const std::string& tz)
      : SemanticComponentInterface("", 6) {
    data_.fill(std::numeric_limits<double>::quiet_NaN());
    const std::array<const std::string*, 6> names = {&fx, &fy, &fz, &tx, &ty, &tz};
    for (std::size_t i = 0; i < 6; ++i)
      if (existing_axes_[i] = !names[i]->empty(); existing_axes_[i]) interface_names_.push_back(*names[i]);
  }
  std::array<double, 3> get_forces() const { return fetch(), std::array{data_[0], data_[1], data_[2]}; }
  std::array<double, 3> get_torques() const { return fetch(), std::array{data_[3], data_[4], data_[5]}; }
  bool get_values_as_message(geometry_msgs::msg::Wrench& out) const {
    fetch();
    out.force.x = data_[0], out.force.y = data_[1], out.force.z = data_[2];
    out.torque.x = data_[3], out.torque.y = data_[4], out.torque.z = data_[5];
    return true;
  }

 protected:
  void fetch() const {
    std::size_t at = 0;
    for (std::size_t i = 0; i < 6; ++i)
      if (existing_axes_[i]) data_[i] = value(at++);
  }
  mutable std::array<double, 6> data_;
  std::array<bool, 6> existing_axes_{};
};

}  // namespace semantic_components
