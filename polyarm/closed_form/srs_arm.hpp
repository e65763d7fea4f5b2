#pragma once
/// Arms of seven turning axes with a spherical shoulder and a spherical wrist, parameterised by the elbow
/// angle: the rotation of the elbow about the line from shoulder to wrist. The elbow angles that joint limits
/// allow have a closed form (Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008, "Analytical inverse kinematic
/// computation for 7-DOF redundant manipulators with joint limits", IEEE T-RO 24). Private to the rooms
/// closed_form and ik. Metres, radians, world frame; const after construction: any thread.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

struct SrsQuestion;

class SrsArm {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;

  /// True if axes 1 to 3 and 5 to 7 meet and are perpendicular to their neighbours, except for rounding.
  static bool fits(const ArmGeometry& arm) noexcept;
  /// Precondition: fits(arm).
  SrsArm(const ArmGeometry& arm, const LaneLimits& limits) noexcept;

  static constexpr std::size_t kMostDips = 8;
  static constexpr std::size_t kMostBorders = 12;  ///< for each side of the elbow: six joints, two limits
  /// Joint states within limits that reach the target, at the local minima of the distance from `near` over
  /// the elbow angle, on either side of the elbow, nearest first. SelfMotion slides from one of them to the
  /// nearest state. Tries one elbow angle in each interval that limits leave and in each sixth of a turn.
  /// Returns their number; 0 if no elbow angle reaches the target within limits. Allocates nothing.
  std::size_t dips(const PoseTarget& target, const double* near,
                   std::span<State, kMostDips> out) const noexcept;

 private:
  friend struct SrsQuestion;
  /// Where a joint reaches one of its limits: `seen` . R(elbow angle) t = `level`, for a vector t of the
  /// question.
  struct Border {
    bool wrist = false;
    bool from_last = false;  ///< relative to the last of the three axes, else to the first
    Vec3 seen;
    double level = 0;
  };
  void add_borders(std::size_t first) noexcept;

  LaneLimits limits_;
  std::array<Vec3, 7> h_;
  Vec3 shoulder_, wrist_;       ///< where the axes meet, at zero
  Vec3 to_elbow_, from_elbow_;  ///< from the shoulder to a point of axis 4, from there to the wrist
  Vec3 wrist_in_tool_;
  Rotation from_tool_rotation_;  ///< transposed rotation of the tool at zero
  Vec3 beside_3_, beside_7_;
  double twice_straight_[2];  ///< twice the angles 2 and 6 at which their neighbours are parallel
  std::array<Border, kMostBorders> borders_;
  std::size_t border_count_ = 0;
};

}  // namespace polyarm::kinematics
