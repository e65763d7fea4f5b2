#pragma once
/// Driver for serial inertial sensors with the WIT standard protocol.
#include <array>

#include "drivers/sensors/serial_sensor.hpp"
#include "drivers/sensors/wit.hpp"

namespace polyarm::sensors {

/// An inertial sensor on a serial port with the WIT standard protocol. States as the IMU broadcaster expects
/// them: orientation of the sensor in its world (quaternion), angular velocity in rad/s and linear
/// acceleration in m/s² in the sensor's axes (at rest, gravity appears as +9.8 m/s² upwards); and temperature
/// in °C, frames, bad_frames, lost_bytes.
class SerialImu : public SerialSensor {
 public:
  explicit SerialImu(Clock clock = realtime::monotonic_now);
  const hardware::DriverFacts* facts() const noexcept override;

 protected:
  void read_parameters(hardware::DriverParameters& parameters) override;
  std::string identify() override;
  void take(std::span<const std::uint8_t> bytes) noexcept override;
  bool expire(Nanoseconds now) noexcept override;
  void forget() noexcept override;

 private:
  enum Group { orientation, velocity, acceleration, group_count };
  void take(const WitFrame& frame) noexcept;
  void set_orientation(double x, double y, double z, double w) noexcept;
  void set_three(Group group, const WitFrame& frame, double full_scale) noexcept;
  void heard(Group group) noexcept;
  bool wanted(Group group) const;
  std::string set_up();
  std::string what_is_missing() const;

  WitReader reader_;
  bool configure_ = false, quaternions_ = false;
  double rate_ = 0;
  std::array<bool, group_count> known_{}, wanted_{};
  std::array<Nanoseconds, group_count> heard_{};  ///< time of arrival
};

}  // namespace polyarm::sensors
