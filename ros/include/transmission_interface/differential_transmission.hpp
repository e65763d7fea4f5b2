#pragma once
#include "transmission_interface/transmission.hpp"

namespace transmission_interface {

/// j1 = (a1/na1 + a2/na2) / (2 nj1) + off1, j2 = (a1/na1 - a2/na2) / (2 nj2) + off2; efforts by the
/// transpose.
class DifferentialTransmission : public internal::Coupled<2> {
 public:
  DifferentialTransmission(const std::vector<double>& actuator, const std::vector<double>& joint,
                           const std::vector<double>& offset = {0.0, 0.0})
      : na_(actuator), nj_(joint), offset_(offset) {
    internal::check_reductions(na_, 2), internal::check_reductions(nj_, 2);
  }
  void actuator_to_joint() override {
    to_joints(position_, offset_[0], offset_[1]);
    to_joints(velocity_, 0, 0);
    for (internal::Quantity* q : {&effort_, &torque_}) {
      if (!q->whole(2)) continue;
      const double a = na_[0] * q->actuators[0].get_value(), b = na_[1] * q->actuators[1].get_value();
      q->joints[0].set_value(nj_[0] * (a + b));
      q->joints[1].set_value(nj_[1] * (a - b));
    }
  }
  void joint_to_actuator() override {
    to_actuators(position_, offset_[0], offset_[1]);
    to_actuators(velocity_, 0, 0);
    for (internal::Quantity* q : {&effort_, &torque_}) {
      if (!q->whole(2)) continue;
      const double a = q->joints[0].get_value() / nj_[0], b = q->joints[1].get_value() / nj_[1];
      q->actuators[0].set_value((a + b) / (2 * na_[0]));
      q->actuators[1].set_value((a - b) / (2 * na_[1]));
    }
  }
  const std::vector<double>& get_actuator_reduction() const { return na_; }
  const std::vector<double>& get_joint_reduction() const { return nj_; }
  const std::vector<double>& get_joint_offset() const { return offset_; }

 private:
  void to_joints(internal::Quantity& q, double first, double second) {
    if (!q.whole(2)) return;
    const double a = q.actuators[0].get_value() / na_[0], b = q.actuators[1].get_value() / na_[1];
    q.joints[0].set_value((a + b) / (2 * nj_[0]) + first);
    q.joints[1].set_value((a - b) / (2 * nj_[1]) + second);
  }
  void to_actuators(internal::Quantity& q, double first, double second) {
    if (!q.whole(2)) return;
    const double a = (q.joints[0].get_value() - first) * nj_[0],
                 b = (q.joints[1].get_value() - second) * nj_[1];
    q.actuators[0].set_value((a + b) * na_[0]);
    q.actuators[1].set_value((a - b) * na_[1]);
  }
  std::vector<double> na_, nj_, offset_;
};

}  // namespace transmission_interface
