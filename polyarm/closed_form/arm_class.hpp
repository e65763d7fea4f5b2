#pragma once
/// Which way an arm's inverse kinematics can be solved in closed form, read off the axes of its joints
/// (Pieper 1968: three consecutive axes that meet or are parallel; the cases and their order after Elias and
/// Wen 2025, "IK-Geo"). Runs when a robot is loaded; allocates.
#include <string>

#include "polyarm/kinematics/arm_geometry.hpp"

namespace polyarm::kinematics {

/// What makes six axes solvable. "Wrist": axes 4, 5, 6 meet in one point.
enum class ArmFamily {
  wrist_2_parallel_3,  ///< most industrial arms
  wrist_1_parallel_2,  ///< a SCARA's shoulder with a wrist
  wrist_1_meets_2,     ///< a shoulder without offset
  wrist_2_meets_3,
  wrist,                   ///< a wrist and nothing else: a quartic
  parallel_234_5_meets_6,  ///< Universal Robots and their kind
  parallel_234,            ///< three parallel axes and nothing else: a quartic
  parallel_123_5_meets_6,
  search_5_meets_6,  ///< two axes that meet and nothing else: closed for each value of axis 4
  search_4_meets_5,  ///< the same for each value of axis 6
  none
};
/// In words, for a person: "a spherical wrist, axes 2 and 3 parallel".
const char* describe(ArmFamily family);
/// Whether its solution goes through the roots of a quartic; else square roots are enough.
bool quartic(ArmFamily family) noexcept;
/// Whether one axis is searched along.
bool searched(ArmFamily family) noexcept;
/// What is cheaper to solve has less: square roots 0, quartics 1, a search 2, none 3.
int effort(ArmFamily family) noexcept;

/// How far axes may be from meeting (in parts of the arm's size) or from parallel (rad) and still count:
/// calibrated descriptions are off by 1e-4 to 1e-3, and solutions are polished on the true arm.
inline constexpr double kLooseTolerance = 1e-3;

/// Six axes and what they are, looked at from the base or from the tool.
struct SixAxisClass {
  ArmFamily family = ArmFamily::none;
  bool from_tool = false;  ///< it is the reversed arm that has the family
  /// The arm that has the family exactly, nearest to the true one; reversed where from_tool.
  ArmGeometry ideal;
  double worst_gap = 0;    ///< by how much axes that should meet do not, m
  double worst_angle = 0;  ///< by how much axes that should be parallel are not, rad
  /// Whether true and ideal arm are the same but for rounding.
  bool exact() const noexcept { return worst_gap < 1e-10 && worst_angle < 1e-11; }
};

/// The first family that fits, quadratic ones before quartic ones, seen from the base before seen from the
/// tool. `arm` has six turning axes; else the answer is none.
SixAxisClass classify(const ArmGeometry& arm, double tolerance = kLooseTolerance);

/// The arm as one of a family already known, without looking again; allocates nothing. For an arm of which
/// one joint is held at one value after another.
SixAxisClass seen_as(const ArmGeometry& arm, ArmFamily family, bool from_tool) noexcept;

/// Why an arm of six axes has no family: which axes miss each other by how much.
std::string why_no_family(const ArmGeometry& arm);

}  // namespace polyarm::kinematics
