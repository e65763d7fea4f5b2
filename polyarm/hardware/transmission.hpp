#pragma once
/// Transmissions between motors and joints: reductions, differentials, four-bar linkages. A driver for motors
/// builds them from its description and applies them in read() and write().
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::hardware {

enum class Quantity : std::uint8_t { position, velocity, effort };
/// Accepts "position" and "absolute_position", "velocity", "effort", "torque" and "force"; other interfaces
/// are not transmitted.
std::optional<Quantity> quantity_of(std::string_view interface);

/// One transmission of one or two joints and as many actuators, n = reduction, off = offset of the joint:
///
///     simple        j = a/n + off
///     differential  j1 = (a1/na1 + a2/na2)/(2 nj1) + off1,  j2 = (a1/na1 − a2/na2)/(2 nj2) + off2
///     four-bar      j1 = a1/(nj1 na1) + off1,               j2 = (a2/na2 − a1/(nj1 na1))/nj2 + off2
///
/// Velocities use the same equations without offsets. Efforts conserve power: simple τj = n τa, differential
/// τj1 = nj1 (na1 τ1 + na2 τ2) and τj2 = nj2 (na1 τ1 − na2 τ2), four-bar τj1 = nj1 na1 τ1 + na2 τ2 and τj2 =
/// nj2 na2 τ2. (transmission_interface of ros2_control.) The n of a simple one is the product of its joint's
/// and its actuator's value, because ROS 1 writes it at the actuator and ROS 2 at the joint.
class Transmission {
 public:
  /// Throws Error with the location of the transmission: "unknown-transmission" (with the nearest name),
  /// "bad-reduction" (zero, or outside the range of a double), "bad-transmission" (wrong number of ends,
  /// wrong or duplicate roles).
  explicit Transmission(const description::TransmissionInfo& info);

  /// Number of joints, and of actuators: 1 or 2.
  std::size_t size() const noexcept { return size_; }
  const std::string& name() const { return name_; }
  /// Ordered by role, like the spans below.
  const std::vector<std::string>& joints() const { return joints_; }
  const std::vector<std::string>& actuators() const { return actuators_; }

  /// Converts actuator measurements to joints. Spans of size() values; both may be the same span. A NaN only
  /// affects values that depend on it. Control thread: no allocation, no lock.
  void to_joints(Quantity quantity, std::span<const double> actuators,
                 std::span<double> joints) const noexcept;
  /// Converts joint commands to actuators.
  void to_actuators(Quantity quantity, std::span<const double> joints,
                    std::span<double> actuators) const noexcept;

 private:
  using Matrix = std::array<std::array<double, 2>, 2>;
  void simple(const description::TransmissionInfo& info);
  void pair(const description::TransmissionInfo& info, bool differential);
  void check(const description::TransmissionInfo& info) const;

  std::string name_;
  std::vector<std::string> joints_, actuators_;
  std::size_t size_ = 1;
  Matrix motion_{};   ///< joint velocity per actuator velocity
  Matrix inverse_{};  ///< actuator velocity per joint velocity
  std::array<double, 2> offset_{};
};

}  // namespace polyarm::hardware
