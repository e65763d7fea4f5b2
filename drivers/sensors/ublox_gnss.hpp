#pragma once
/// Driver for u-blox satellite receivers.
#include "drivers/sensors/serial_sensor.hpp"
#include "drivers/sensors/ubx.hpp"

namespace polyarm::sensors {

/// A u-blox satellite receiver on a serial port or its own USB. States as the GPS broadcaster expects them
/// (status and service of NavSatStatus, latitude and longitude in degrees, altitude in m above the ellipsoid,
/// the three covariances in m²); and velocity.east, .north and .up and speed_accuracy in m/s, satellites,
/// fix_type, frames, bad_frames, lost_bytes. Without a fix: status -1, the others NaN.
class UbloxGnss : public SerialSensor {
 public:
  explicit UbloxGnss(Clock clock = realtime::monotonic_now);
  const hardware::DriverFacts* facts() const noexcept override;

 protected:
  void read_parameters(hardware::DriverParameters& parameters) override;
  std::string identify() override;
  void take(std::span<const std::uint8_t> bytes) noexcept override;
  bool expire(Nanoseconds now) noexcept override;
  void forget() noexcept override;

 private:
  enum class Answer { none, accepted, refused };
  void take(const UbxMessage& message) noexcept;
  void take(const NavPvt& fix) noexcept;
  void no_fix() noexcept;
  bool ask_version();
  std::string set_up(bool by_keys);
  std::string command(UbxId id, std::span<const std::uint8_t> message);
  std::string no_answer() const;
  bool over_usb() const;

  UbxReader reader_;
  std::string configure_, receiver_port_;
  double rate_ = 0, service_ = 0;
  // during identification
  ReceiverVersion version_;
  bool has_version_ = false, identifying_ = false;
  UbxId asked_;
  Answer answer_ = Answer::none;
  bool fixes_ = false;     ///< a NAV-PVT has arrived and is not too old
  Nanoseconds heard_ = 0;  ///< time of the last one, or when waiting began
};

}  // namespace polyarm::sensors
