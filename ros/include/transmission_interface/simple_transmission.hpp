#pragma once
#include "transmission_interface/transmission.hpp"

namespace transmission_interface {

/// joint position = actuator / n + off, velocity = actuator / n, effort = actuator * n.
class SimpleTransmission : public internal::Coupled<1> {
 public:
  explicit SimpleTransmission(double reduction, double offset = 0.0) : n_(reduction), offset_(offset) {
    internal::check_reductions({reduction}, 1);
  }
  void actuator_to_joint() override {
    if (position_.whole(1)) position_.joints[0].set_value(position_.actuators[0].get_value() / n_ + offset_);
    if (velocity_.whole(1)) velocity_.joints[0].set_value(velocity_.actuators[0].get_value() / n_);
    for (internal::Quantity* q : {&effort_, &torque_})
      if (q->whole(1)) q->joints[0].set_value(q->actuators[0].get_value() * n_);
  }
  void joint_to_actuator() override {
    if (position_.whole(1))
      position_.actuators[0].set_value((position_.joints[0].get_value() - offset_) * n_);
    if (velocity_.whole(1)) velocity_.actuators[0].set_value(velocity_.joints[0].get_value() * n_);
    for (internal::Quantity* q : {&effort_, &torque_})
      if (q->whole(1)) q->actuators[0].set_value(q->joints[0].get_value() / n_);
  }
  double get_actuator_reduction() const { return n_; }
  double get_joint_offset() const { return offset_; }

 private:
  double n_, offset_;
};

}  // namespace transmission_interface
