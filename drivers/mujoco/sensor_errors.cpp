#include "drivers/mujoco/sensor_errors.hpp"

#include <cmath>
#include <numbers>

namespace polyarm::drivers {

SensorErrors::SensorErrors(const hardware::ForceSensorErrors& errors, std::uint64_t stream)
    : errors_(errors), state_((std::uint64_t{errors.seed} << 32) + stream), zero_(errors.bias) {}

/// In (0, 1], by splitmix64.
double SensorErrors::unit() noexcept {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>(((z ^ (z >> 31)) >> 11) + 1) * 0x1p-53;
}

/// Of the standard normal distribution, by Box and Muller.
double SensorErrors::normal() noexcept {
  const double radius = std::sqrt(-2 * std::log(unit()));
  return radius * std::cos(2 * std::numbers::pi * unit());
}

void SensorErrors::add(double dt, double* wrench) noexcept {
  const double step = std::sqrt(dt / 60);  // of a random walk, as a share of its deviation after a minute
  for (std::size_t i = 0; i < zero_.size(); ++i) {
    const bool force = i < 3;
    if (const double drift = force ? errors_.drift : errors_.torque_drift; drift > 0)
      zero_[i] += drift * step * normal();
    wrench[i] += zero_[i];
    if (const double noise = force ? errors_.noise : errors_.torque_noise; noise > 0)
      wrench[i] += noise * normal();
  }
}

}  // namespace polyarm::drivers
