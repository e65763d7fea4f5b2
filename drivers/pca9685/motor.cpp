#include "drivers/pca9685/motor.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/pca9685/chip.hpp"

namespace polyarm::drivers {

using pca9685::kTicks;

MotorOutput drive_at(const MotorSettings& motor, double velocity) noexcept {
  const double factor = motor.speed_scale * motor.trim;
  const double asked = std::abs(velocity) * factor;
  const double reach = motor.most_duty > motor.least_duty
                           ? (motor.most_duty - motor.least_duty) / (1 - motor.least_duty)
                           : 0;  // the largest `asked` below the clamp
  const double given = std::min(asked, reach);
  const double duty = motor.least_duty + (1 - motor.least_duty) * given;
  const int ticks = std::min(static_cast<int>(std::lround(duty * kTicks)),
                             static_cast<int>(std::floor(motor.most_duty * kTicks)));
  if (std::abs(velocity) < motor.dead_band || given <= 0 || ticks <= 0)
    return motor.brake ? MotorOutput{{kTicks, kTicks, kTicks}, 0} : release_now();
  const bool forward = velocity * motor.direction > 0;
  return {{ticks, forward ? kTicks : 0, forward ? 0 : kTicks}, std::copysign(given / factor, velocity)};
}

}  // namespace polyarm::drivers
