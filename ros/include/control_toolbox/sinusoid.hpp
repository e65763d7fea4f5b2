#pragma once
/// offset + amplitude sin(2π frequency t + phase), with its first and second derivatives.
#include <cmath>

namespace control_toolbox {
class Sinusoid {
 public:
  Sinusoid() = default;
  Sinusoid(double offset, double amplitude, double frequency, double phase)
      : offset_(offset), amplitude_(amplitude), frequency_(frequency), phase_(phase) {}
  double update(double time, double& qd, double& qdd) const {
    const double w = 2 * M_PI * frequency_, angle = w * time + phase_;
    qd = w * amplitude_ * std::cos(angle);
    qdd = -w * w * amplitude_ * std::sin(angle);
    return offset_ + amplitude_ * std::sin(angle);
  }

 private:
  double offset_ = 0, amplitude_ = 0, frequency_ = 0, phase_ = 0;
};
}  // namespace control_toolbox
