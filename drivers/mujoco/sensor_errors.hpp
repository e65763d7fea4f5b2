#pragma once
/// Noise, bias and drift of a simulated force/torque sensor. N, N m, s. Control thread.
#include <cstdint>

#include "polyarm/hardware/force_sensor.hpp"

namespace polyarm::drivers {

/// Adds errors to readings. The same seed and stream give the same errors on every run.
class SensorErrors {
 public:
  /// `stream`: another series for each sensor with the same seed.
  SensorErrors(const hardware::ForceSensorErrors& errors, std::uint64_t stream);
  /// Adds the errors of the next reading, `dt` after the one before, to force x y z and torque x y z.
  void add(double dt, double* wrench) noexcept;

 private:
  double normal() noexcept;
  double unit() noexcept;

  hardware::ForceSensorErrors errors_;
  std::uint64_t state_;
  std::array<double, 6> zero_;
};

}  // namespace polyarm::drivers
