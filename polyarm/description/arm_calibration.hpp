#pragma once
/// The measured geometry of one arm, in place of the nominal one: a file `polyarm: arm_calibration/1`.
/// Metres, radians. Any thread.
#include <filesystem>
#include <map>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

struct ArmCalibration {
  std::string robot;                    ///< the model that it belongs to, as the catalogue names it
  std::string source;                   ///< where it comes from, for people
  std::map<std::string, Pose> origins;  ///< T_parent_joint at zero, by joint
};

/// Larger differences from the description are those of another robot: m and rad.
inline constexpr double kMostShift = 0.05, kMostTilt = 0.1;

/// Throws Error with all faults of the file.
ArmCalibration read_arm_calibration(const std::filesystem::path& path);
/// The text of such a file; reads back to the same numbers.
std::string arm_calibration_text(const ArmCalibration& calibration);
/// Replaces the origins. Throws Error("unknown-joint") for a joint that the robot does not have, and
/// Error("other-robot") for an origin that is farther away than kMostShift or kMostTilt; the model stays
/// unchanged then.
void apply(const ArmCalibration& calibration, RobotModel& model, const Location& where = {});

}  // namespace polyarm::description
