#pragma once
#include "transmission_interface/transmission.hpp"

namespace transmission_interface {

/// j1 = a1/(nj1 na1) + off1, j2 = (a2/na2 - a1/(nj1 na1))/nj2 + off2; efforts by the transpose.
class FourBarLinkageTransmission : public internal::Coupled<2> {
 public:
  FourBarLinkageTransmission(const std::vector<double>& actuator, const std::vector<double>& joint,
                             const std::vector<double>& offset = {0.0, 0.0})
      : na_(actuator), nj_(joint), offset_(offset) {
    internal::check_reductions(na_, 2), internal::check_reductions(nj_, 2);
  }
  void actuator_to_joint() override {
    to_joints(position_, offset_[0], offset_[1]);
    to_joints(velocity_, 0, 0);
    for (internal::Quantity* q : {&effort_, &torque_}) {
      if (!q->whole(2)) continue;
      const double second = nj_[1] * na_[1] * q->actuators[1].get_value();
      q->joints[0].set_value(nj_[0] * na_[0] * q->actuators[0].get_value() + second);
      q->joints[1].set_value(second);
    }
  }
  void joint_to_actuator() override {
    to_actuators(position_, offset_[0], offset_[1]);
    to_actuators(velocity_, 0, 0);
    for (internal::Quantity* q : {&effort_, &torque_}) {
      if (!q->whole(2)) continue;
      const double first = q->joints[0].get_value(), second = q->joints[1].get_value();
      q->actuators[0].set_value((first - second) / (nj_[0] * na_[0]));
      q->actuators[1].set_value(second / (nj_[1] * na_[1]));
    }
  }

 private:
  void to_joints(internal::Quantity& q, double first, double second) {
    if (!q.whole(2)) return;
    const double j1 = q.actuators[0].get_value() / (nj_[0] * na_[0]);
    q.joints[0].set_value(j1 + first);
    q.joints[1].set_value((q.actuators[1].get_value() / na_[1] - j1) / nj_[1] + second);
  }
  void to_actuators(internal::Quantity& q, double first, double second) {
    if (!q.whole(2)) return;
    const double j1 = q.joints[0].get_value() - first, j2 = q.joints[1].get_value() - second;
    q.actuators[0].set_value(j1 * nj_[0] * na_[0]);
    q.actuators[1].set_value((j1 + j2 * nj_[1]) * na_[1]);
  }
  std::vector<double> na_, nj_, offset_;
};

}  // namespace transmission_interface
