#pragma once
/// Seven turning axes with a spherical shoulder and a spherical wrist, by the elbow angle: how far the elbow
/// is turned about the line from shoulder to wrist. Which elbow angles joint limits allow is known in closed
/// form (Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008, "Analytical inverse kinematic computation for 7-DOF
/// redundant manipulators with joint limits", IEEE T-RO 24). Used inside this room only.
#include <array>
#include <cstddef>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

struct SrsQuestion;

class SrsArm {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;

  /// Whether axes 1 to 3 and 5 to 7 meet and are square to their neighbours, but for rounding.
  static bool fits(const ArmGeometry& arm) noexcept;
  /// Precondition: fits(arm).
  explicit SrsArm(const ArmGeometry& arm) noexcept;

  /// The joint state within limits that is nearest to `near`; false where no elbow angle leads there within
  /// limits. Eight elbow angles at a time: one in each stretch that limits leave and in each sixteenth of a
  /// turn, then ever closer around the best of either side of the elbow. Allocates nothing.
  bool nearest(const PoseTarget& target, const LaneLimits& limits, const double* near,
               State& out) const noexcept;

 private:
  friend struct SrsQuestion;
  std::array<Vec3, 7> h_;
  Vec3 shoulder_, wrist_;       ///< where the axes meet, at zero
  Vec3 to_elbow_, from_elbow_;  ///< from the shoulder to a point of axis 4, from there to the wrist
  Vec3 wrist_in_tool_;
  Rotation from_tool_rotation_;  ///< transposed rotation of the tool at zero
  Vec3 beside_3_, beside_7_;
};

}  // namespace polyarm::kinematics
