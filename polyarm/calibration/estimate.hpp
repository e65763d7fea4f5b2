#pragma once
/// What every calibration returns besides its result: residuals, uncertainty, and the sample that does not
/// fit. Metres, radians. Plain data.
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "polyarm/base/pose.hpp"

namespace polyarm::calibration {

/// A pose with its uncertainty. Both are in the frame in which the pose is given.
struct PoseEstimate {
  Pose pose;
  /// Covariance of the error, row-major: x y z (m) and the rotation vector about the outer axes (rad).
  std::array<double, 36> covariance{};
  double position_sigma = 0;  ///< m: one standard deviation in the worst direction
  double rotation_sigma = 0;  ///< rad: the same
};

/// How far a sample is from the result.
struct Residual {
  double position = 0;  ///< m
  double rotation = 0;  ///< rad; 0 if the samples have no orientation
};

/// A sample that the others contradict.
struct Outlier {
  std::size_t sample = 0;
  /// The probability that one of so many good samples is this far off (F test with Bonferroni's correction).
  double chance = 0;
  double improvement = 1;  ///< factor by which the root mean square of the residuals falls without it
};

struct Residuals {
  std::vector<Residual> each;
  Residual rms, largest;
  std::optional<Outlier> outlier;
};

}  // namespace polyarm::calibration
