#pragma once
/// Errors of an arm's geometry from measured poses: joint offsets, and the places of the joint axes. Metres,
/// radians. Any thread; no hidden state.
#include <map>
#include <span>
#include <string>
#include <vector>

#include "polyarm/calibration/estimate.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::calibration {

/// Joint values, in the order of RobotModel::actuated, and what a measuring device saw.
struct ArmSample {
  std::vector<double> q;
  Pose measured;  ///< of the target on the hand, in the frame of the device
};

struct ArmOptions {
  bool axes = false;            ///< also the four numbers that place each axis, not only the joint offsets
  bool positions_only = false;  ///< the device measures positions; orientations are ignored
  bool base_known = false;      ///< the device measures in the robot's base
  bool target_known = false;    ///< the target is tool0
};

/// One number of the geometry.
struct ArmNumber {
  std::string name;          ///< "elbow_joint offset", "elbow_joint tilt 1", "elbow_joint shift 2"
  double value = 0;          ///< rad or m
  double sigma = 0;          ///< one standard deviation
  bool identifiable = true;  ///< false: the samples do not determine it; its value is the smallest that fits
};

struct ArmErrors {
  std::vector<ArmNumber> numbers;
  PoseEstimate base;        ///< of the robot, in the frame of the device
  PoseEstimate target;      ///< in tool0
  Residuals before, after;  ///< without and with the corrections
  /// The corrected origins of the joints: T_parent_joint at zero. The joint offsets are part of them.
  std::map<std::string, Pose> origins;
};

/// Least squares on the product of exponentials. `tip`: the link that is tool0. Numbers that no sample can
/// tell apart (an offset of the first joint and the angle of an unknown base) are reported as not
/// identifiable and stay as small as possible. Throws Error("bad-points") if there are too few samples or
/// they have the wrong number of joints.
ArmErrors arm_errors(const description::RobotModel& model, int tip, std::span<const ArmSample> samples,
                     const ArmOptions& options);

/// The residuals of the arm as `model` has it: only the base and the target are fitted, which takes fewer
/// samples. To check a calibration that the model contains. Throws as arm_errors() does.
Residuals arm_residuals(const description::RobotModel& model, int tip, std::span<const ArmSample> samples,
                        const ArmOptions& options);

/// A joint axis at zero joint values, in the frame of the root link.
struct AxisLine {
  Vec3 direction, point;
};
/// The origins of the joints for which the axes of the arm from root to `tip` are `axes`, and the tip at zero
/// joint values is at `tip_at_zero`. Each joint's frame moves as little as possible. Throws
/// Error("bad-model") if the joints on the way are not a plain series, or if no fixed joint behind the last
/// axis can take up the rest.
std::map<std::string, Pose> origins_for(const description::RobotModel& model, int tip,
                                        std::span<const AxisLine> axes, const Pose& tip_at_zero);

/// How much another geometry moves the tip within the joint ranges, over 200 spread joint states.
Residual difference_of(const description::RobotModel& one, const description::RobotModel& other, int tip);

}  // namespace polyarm::calibration
