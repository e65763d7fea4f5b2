#pragma once
/// What is between motors and joints: reductions, differentials, four-bar linkages. A driver that knows
/// motors builds them from its description and steps them in read() and write().
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
/// "position" and "absolute_position", "velocity", "effort", "torque" and "force"; others are not
/// transmitted.
std::optional<Quantity> quantity_of(std::string_view interface);

/// One transmission of one or two joints and as many actuators, n = reduction, off = offset of the joint:
///
///     simple        j = a/n + off
///     differential  j1 = (a1/na1 + a2/na2)/(2 nj1) + off1,  j2 = (a1/na1 − a2/na2)/(2 nj2) + off2
///     four-bar      j1 = a1/(nj1 na1) + off1,               j2 = (a2/na2 − a1/(nj1 na1))/nj2 + off2
///
/// Velocities go the same way without the offsets. Efforts go the way that keeps the power: simple τj = n τa,
/// differential τj1 = nj1 (na1 τ1 + na2 τ2) and τj2 = nj2 (na1 τ1 − na2 τ2), four-bar τj1 = nj1 na1 τ1 + na2
/// τ2 and τj2 = nj2 na2 τ2. (transmission_interface of ros2_control.) The n of a simple one is the product of
/// what its joint and its actuator say, since ROS 1 writes it at the actuator and ROS 2 at the joint.
class Transmission {
 public:
  /// Throws Error with the place of the transmission: "unknown-transmission" (nearest name), "bad-reduction"
  /// (zero, or beyond what a double holds), "bad-transmission" (wrong number of ends, wrong or doubled
  /// roles).
  explicit Transmission(const description::TransmissionInfo& info);

  /// How many joints, and how many actuators: 1 or 2.
  std::size_t size() const noexcept { return size_; }
  const std::string& name() const { return name_; }
  /// In the order of their roles, which is the order of the spans below.
  const std::vector<std::string>& joints() const { return joints_; }
  const std::vector<std::string>& actuators() const { return actuators_; }

  /// What the actuators measured, as joints. Spans of size() values, which may be the same one. A NaN reaches
  /// only what depends on it. Control thread: no allocation, no lock.
  void to_joints(Quantity quantity, std::span<const double> actuators,
                 std::span<double> joints) const noexcept;
  /// What the joints are commanded, as actuators.
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
  Matrix motion_{};   ///< joint velocity for each actuator velocity
  Matrix inverse_{};  ///< actuator velocity for each joint velocity
  std::array<double, 2> offset_{};
};

}  // namespace polyarm::hardware
