#pragma once
/// The kinds of `polyarm calibrate`: from samples to a result, and from a stored result to its check.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/calibration/estimate.hpp"
#include "polyarm/calibration/payload.hpp"
#include "polyarm/calibration/samples.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::apps {

struct CalibrateOptions {
  std::string kind, in;
  const description::RobotModel* robot = nullptr;  ///< for joints, and payload from joint torques
  std::string robot_name;
  std::vector<calibration::Sample> flat;  ///< tool: poses with its face on a plane
  bool axes = false, positions = false, base_known = false, target_known = false;  ///< joints
  bool inertia = false, friction = false;                                          ///< payload
};

/// What a calibration found.
struct Calibrated {
  std::vector<std::string> lines;  ///< the result with its uncertainty
  calibration::Residuals residuals;
  const char* unit = "mm";                         ///< of the residuals' positions
  double scale = 1e3;                              ///< from SI to `unit`
  bool rotations = false;                          ///< the residuals have rotations
  std::optional<data::Point> point;                ///< what a data file stores
  std::optional<description::ArmCalibration> arm;  ///< what the file of an arm stores
  std::optional<calibration::Payload> payload;     ///< all that the hand carries
  std::string next;                                ///< the next sample that helps most; may be empty
};

/// Throws Error if the samples do not determine the result.
Calibrated calibrate(const std::vector<calibration::Sample>& samples, const CalibrateOptions& options);
/// The value of the key `payload` of a robot.
std::string payload_text(const calibration::Payload& payload);
/// The residuals of samples against a stored result, without fitting it.
Calibrated check_calibration(const std::vector<calibration::Sample>& samples, const Pose& stored,
                             const CalibrateOptions& options);
/// The same for the geometry of an arm.
Calibrated check_arm(const std::vector<calibration::Sample>& samples,
                     const description::ArmCalibration& stored, CalibrateOptions options);

}  // namespace polyarm::apps
