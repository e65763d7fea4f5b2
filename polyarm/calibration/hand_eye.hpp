#pragma once
/// Where a camera is, from poses of a marker that it sees while the robot moves: on the hand or beside the
/// robot. Metres, radians. Any thread; no hidden state.
#include <span>
#include <vector>

#include "polyarm/calibration/estimate.hpp"

namespace polyarm::calibration {

enum class CameraPlace { on_hand, beside };

/// One picture. The robot is at rest.
struct Sighting {
  Pose flange;  ///< T_base_flange (tool0)
  Pose marker;  ///< T_camera_marker: z of the camera looks forward, x to the right of the picture
};

struct HandEye {
  PoseEstimate camera;  ///< on_hand: in the flange (tool0); beside: in the robot's base
  PoseEstimate marker;  ///< on_hand: in the robot's base; beside: in the flange
  /// Of each sighting: the marker as predicted, against the marker as seen.
  Residuals residuals;
  double position_noise = 0, rotation_noise = 0;  ///< one standard deviation of the sightings, m and rad
};

/// Solves A_i Q = P M_i for the camera P and the marker Q. The closed form takes the rotation from all pairs
/// of motions at once (Park and Martin 1994) and both positions from one linear problem; the refinement
/// minimises the differences between seen and predicted marker poses over both poses on SE(3), with position
/// and rotation weighted by their own noise, which is estimated from the samples. Throws Error("bad-points")
/// with the reason for fewer than three sightings, turns below 10 degrees, and turns about one axis only,
/// which leave the position along it free.
HandEye hand_eye(std::span<const Sighting> sightings, CameraPlace place);

/// A pose for the next sample, and what it is expected to bring.
struct NextPose {
  Pose flange;            ///< in the base
  double sigma_now = 0;   ///< m: of the result now
  double sigma_then = 0;  ///< m: expected with this sample
};
/// The pose that lowers the uncertainty of the camera's position most, out of turns of the known poses by 20
/// and 40 degrees about the marker, so that the camera still sees it.
NextPose next_sighting(std::span<const Sighting> sightings, CameraPlace place, const HandEye& result);
/// The same for the TCP of a tool: turns about the tip.
NextPose next_touch(std::span<const Pose> poses);

}  // namespace polyarm::calibration
