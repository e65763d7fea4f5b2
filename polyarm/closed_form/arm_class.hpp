#pragma once
/// Finds the closed form for an arm's inverse kinematics from the axes of its joints (Pieper 1968: three
/// consecutive axes that meet or are parallel; the cases and their order after Elias and Wen 2025, "IK-Geo").
/// Runs when a robot is loaded; allocates. Metres, radians, world frame. Any thread; no hidden state.
#include <string>

#include "polyarm/kinematics/arm_geometry.hpp"

namespace polyarm::kinematics {

/// The property that makes six axes solvable. "Wrist": axes 4, 5, 6 meet in one point.
enum class ArmFamily {
  wrist_2_parallel_3,  ///< most industrial arms
  wrist_1_parallel_2,  ///< a SCARA's shoulder with a wrist
  wrist_1_meets_2,     ///< a shoulder without offset
  wrist_2_meets_3,
  wrist,                   ///< a wrist only: needs a quartic
  parallel_234_5_meets_6,  ///< Universal Robots and similar arms
  parallel_234,            ///< three parallel axes only: needs a quartic
  parallel_123_5_meets_6,
  search_5_meets_6,  ///< only two axes meet: closed form for each value of axis 4
  search_4_meets_5,  ///< the same for each value of axis 6
  none
};
/// The family as text for a person: "a spherical wrist, axes 2 and 3 parallel".
const char* describe(ArmFamily family);
/// True if the solution needs the roots of a quartic; else square roots suffice.
bool quartic(ArmFamily family) noexcept;
/// True if the solution searches along one axis.
bool searched(ArmFamily family) noexcept;
/// The cost of solving: square roots 0, quartics 1, a search 2, no closed form 3.
int effort(ArmFamily family) noexcept;

/// Tolerance for axes that count as meeting (in units of the arm's size) or as parallel (rad). Calibrated
/// descriptions are off by 1e-4 to 1e-3; solutions are polished on the true arm.
inline constexpr double kLooseTolerance = 1e-3;

/// The family of six axes, seen from the base or from the tool.
struct SixAxisClass {
  ArmFamily family = ArmFamily::none;
  bool from_tool = false;  ///< the reversed arm has the family
  /// The arm nearest to the true one that has the family exactly; reversed if from_tool.
  ArmGeometry ideal;
  double worst_gap = 0;    ///< largest distance between axes that should meet, m
  double worst_angle = 0;  ///< largest angle between axes that should be parallel, rad
  /// True if the true and the ideal arm differ only by rounding.
  bool exact() const noexcept { return worst_gap < 1e-10 && worst_angle < 1e-11; }
};

/// The first family that fits: quadratic before quartic, seen from the base before seen from the tool. The
/// family is `none` unless `arm` has six turning axes.
SixAxisClass classify(const ArmGeometry& arm, double tolerance = kLooseTolerance);

/// The arm as a member of a known family, without a new classification; allocates nothing. For an arm with
/// one joint fixed at one value after another.
SixAxisClass seen_as(const ArmGeometry& arm, ArmFamily family, bool from_tool) noexcept;

/// The reason why an arm of six axes has no family: which axes miss each other by how much.
std::string why_no_family(const ArmGeometry& arm);

}  // namespace polyarm::kinematics
