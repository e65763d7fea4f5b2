#pragma once
/// Mass, centre of mass and inertia of what the hand carries, from forces while the arm moves or rests in
/// several poses. SI units. Any thread; no hidden state.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/calibration/estimate.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::calibration {

/// A reading of a force sensor at the wrist, in the sensor's axes.
struct WrenchSample {
  Quaternion rotation;  ///< R_world_sensor; the world's z points up
  /// At rest, a held weight gives a force that points down.
  Vec3 force, torque;
  // Motion of the sensor's origin; zero at rest.
  Vec3 angular_velocity, angular_acceleration, acceleration;  ///< rad/s, rad/s^2, m/s^2
};

/// Measured joint torques, in the order of RobotModel::actuated.
struct TorqueSample {
  std::vector<double> q, v, a, tau;
};

struct PayloadOptions {
  bool inertia = false;   ///< also the inertia; needs quick turns
  bool offsets = true;    ///< wrench: the sensor's zero is unknown
  bool friction = false;  ///< torques: Coulomb and viscous friction of each joint are unknown
};

struct Payload {
  double mass = 0, mass_sigma = 0;  ///< kg
  Vec3 center;                      ///< in the sensor's or the tip's frame, m
  double center_sigma = 0;          ///< m: one standard deviation in the worst direction
  std::array<double, 6> inertia{};  ///< about the centre: ixx ixy ixz iyy iyz izz, kg m^2
  double inertia_sigma = 0;         ///< kg m^2: the largest standard deviation
  bool inertia_known = false;
  Vec3 force_offset, torque_offset;  ///< of the sensor's zero
  std::vector<double> residuals;     ///< of each sample: N (wrench) or N m (torques)
  double rms = 0;
  std::optional<Outlier> outlier;
};

/// Linear least squares. Throws Error("bad-points") if the samples do not determine the payload: too few, too
/// little change of orientation, or with `inertia` too little angular acceleration.
Payload payload_from_wrenches(std::span<const WrenchSample> samples, const PayloadOptions& options = {});
/// The same from joint torques, minus those that the model of the arm needs. `tip`: the link that carries the
/// payload. The masses of the arm must be right: their errors count as payload.
Payload payload_from_torques(const description::RobotModel& model, int tip,
                             std::span<const TorqueSample> samples, const PayloadOptions& options = {});

/// A load without an inertia of its own.
struct KnownLoad {
  double mass = 0;  ///< kg
  Vec3 center;      ///< in the sensor's or the tip's frame, m
};
/// What the measured total is without a part of it, for example the tool. Throws Error("bad-points") if less
/// is left than three times the uncertainty of the mass.
Payload without_part(Payload total, const KnownLoad& part, const std::string& name);

/// How far each sample is from what a known load gives, at rest: N. The sensor's zero is unknown and taken as
/// the mean difference, so two samples or more are needed; throws Error("bad-points") if there are fewer.
std::vector<double> load_residuals(std::span<const WrenchSample> samples, const KnownLoad& load);
/// The same of joint torques: N m.
std::vector<double> load_residuals(const description::RobotModel& model, int tip,
                                   std::span<const TorqueSample> samples, const KnownLoad& load);

}  // namespace polyarm::calibration
