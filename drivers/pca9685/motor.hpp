#pragma once
/// Converts the velocity of a wheel into the three channels of its motor. Any thread; nothing allocates.
#include <array>

namespace polyarm::drivers {

/// The wiring and the characteristics of a motor.
struct MotorSettings {
  int enable = 0, positive = 1, negative = 2;  ///< channels of the chip, 0 to 15
  double speed_scale = 1;                      ///< duty per rad/s of the wheel
  double trim = 1;                             ///< correction factor that makes two motors equally fast
  double direction = 1;                        ///< -1: the motor is connected or mounted in reverse
  double dead_band = 0.001;                    ///< rad/s; a slower command counts as a stop
  double least_duty = 0;                       ///< the duty at which the wheel begins to turn
  double most_duty = 1;                        ///< upper limit of the duty
  bool brake = false;                          ///< a stop shorts the motor; else it coasts
};

/// The channel values of a motor, in ticks of 0 to 4096.
struct MotorDrive {
  int enable = 0, positive = 0, negative = 0;
  bool operator==(const MotorDrive&) const = default;
};

struct MotorOutput {
  MotorDrive drive;
  double velocity = 0;  ///< rad/s represented by this drive: the command after dead band and clamp
};

/// Without a command: all three channels off, the motor coasts.
inline MotorOutput release_now() {
  return {};
}
/// For a finite velocity in rad/s. The duty is least + (1 - least) · |velocity| · scale · trim, at most
/// `most_duty`, rounded to a tick; a stop is a brake (all three channels on) or coasting.
MotorOutput drive_at(const MotorSettings& motor, double velocity) noexcept;

}  // namespace polyarm::drivers
