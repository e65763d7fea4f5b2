#pragma once
/// From the velocity of a wheel to the three channels of its motor.
#include <array>

namespace polyarm::drivers {

/// How a motor is connected and driven.
struct MotorSettings {
  int enable = 0, positive = 1, negative = 2;  ///< channels of the chip, 0 to 15
  double speed_scale = 1;                      ///< duty per rad/s of the wheel
  double trim = 1;                             ///< factor that makes two motors go alike
  double direction = 1;                        ///< -1: the motor is connected or mounted the other way round
  double dead_band = 0.001;                    ///< rad/s; slower commands are a stop
  double least_duty = 0;                       ///< the duty at which the wheel begins to turn
  double most_duty = 1;                        ///< never more than this
  bool brake = false;                          ///< a stop shorts the motor; else it rolls out
};

/// What the channels of a motor shall be, in ticks of 0 to 4096.
struct MotorDrive {
  int enable = 0, positive = 0, negative = 0;
  bool operator==(const MotorDrive&) const = default;
};

struct MotorOutput {
  MotorDrive drive;
  double velocity = 0;  ///< rad/s that this stands for: the command after dead band and clamp
};

/// Nobody commands the motor: all three channels off, it rolls out.
inline MotorOutput let_go() {
  return {};
}
/// For a finite velocity in rad/s. The duty is least + (1 - least) · |velocity| · scale · trim, at most
/// `most_duty`, rounded to a tick; a stop is a brake (all three channels on) or nothing.
MotorOutput drive_at(const MotorSettings& motor, double velocity) noexcept;

}  // namespace polyarm::drivers
