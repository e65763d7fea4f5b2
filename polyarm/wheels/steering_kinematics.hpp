#pragma once
/// Kinematics of bases that steer: a traction axle behind, steering in front (the single-track model). Angles
/// in rad, positive to the left; lengths in m. Real-time, all of it.
#include <array>
#include <cstdint>

namespace polyarm::controllers {

struct SteeringGeometry {
  /// One traction wheel and one steering joint; two and one; two and two.
  enum class Kind : std::uint8_t { bicycle, tricycle, ackermann };
  Kind kind = Kind::bicycle;
  double wheelbase = 1;       ///< from the traction axle to the steering axle
  double traction_track = 1;  ///< between the traction wheels
  double steering_track = 1;  ///< between the steering axes
  double radius = 1;          ///< of the traction wheels

  std::size_t traction_wheels() const noexcept { return kind == Kind::bicycle ? 1 : 2; }
  std::size_t steering_joints() const noexcept { return kind == Kind::ackermann ? 2 : 1; }
};

/// Right, left; of a single joint the first counts.
using RightLeft = std::array<double, 2>;

/// No base steers farther on its ways, rad: the wheels would slip.
inline constexpr double kMostSteering = 1.0471975511965976;

/// Largest curvature (1/m) at which no steering joint is beyond `limit` (rad, above 0), nor beyond
/// kMostSteering.
double sharpest_curvature(const SteeringGeometry& geometry, double limit) noexcept;

/// Angle of the middle of the steering axle for a speed v (m/s) and a turn rate w (rad/s). Without both it is
/// 0; a turn without speed gives a quarter turn.
double steering_angle(const SteeringGeometry& geometry, double v, double w) noexcept;

/// Angles of the steering joints when the middle of their axle has the angle `middle`: no wheel slips.
RightLeft steering_joints(const SteeringGeometry& geometry, double middle) noexcept;
/// The angle of the middle, of two joints the mean of what each says.
double middle_angle(const SteeringGeometry& geometry, const RightLeft& joints) noexcept;

/// Velocities of the traction wheels (rad/s) for a velocity `wheel` of a wheel in their middle.
RightLeft traction_wheels(const SteeringGeometry& geometry, double wheel, double middle) noexcept;
/// Speed (m/s) of the middle of the traction axle, of two wheels the mean of what each says.
double traction_speed(const SteeringGeometry& geometry, const RightLeft& wheels, double middle) noexcept;

/// Share of the wheel velocity while the steering is `error` away from its angle: 1 below 30 degrees, then
/// cos(error) / cos(30 degrees), never quite 0.
double share_while_steering(double error) noexcept;

}  // namespace polyarm::controllers
