#pragma once
/// Seven turning axes with a spherical shoulder and a spherical wrist, by the elbow angle: how far the elbow
/// is turned about the line from shoulder to wrist. Which elbow angles joint limits allow is known in closed
/// form (Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008, "Analytical inverse kinematic computation for 7-DOF
/// redundant manipulators with joint limits", IEEE T-RO 24). Used inside this room only.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

struct SrsQuestion;

class SrsArm {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;

  /// Whether axes 1 to 3 and 5 to 7 meet and are square to their neighbours, but for rounding.
  static bool fits(const ArmGeometry& arm) noexcept;
  /// Precondition: fits(arm).
  SrsArm(const ArmGeometry& arm, const LaneLimits& limits) noexcept;

  static constexpr std::size_t kMostDips = 8;
  static constexpr std::size_t kMostBorders = 12;  ///< of each side of the elbow: six joints, two limits
  /// Joint states within limits that lead to the target, of which one slides (SelfMotion) to the one that is
  /// nearest to `near`: where the distance has a dip over the elbow angle, on either side of the elbow, the
  /// nearer first. Looks at one elbow angle in each stretch that limits leave and in each sixth of a turn.
  /// Returns how many; 0 where no elbow angle leads there within limits. Allocates nothing.
  std::size_t dips(const PoseTarget& target, const double* near,
                   std::span<State, kMostDips> out) const noexcept;

 private:
  friend struct SrsQuestion;
  /// Where a joint comes to one of its limits: `seen` . R(elbow angle) t = `level`, for a vector t that the
  /// question has.
  struct Border {
    bool wrist = false;
    bool from_last = false;  ///< seen from the last axis of the three, else from the first
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
  double twice_straight_[2];  ///< twice angles 2 and 6 at which their neighbours are along each other
  std::array<Border, kMostBorders> borders_;
  std::size_t border_count_ = 0;
};

}  // namespace polyarm::kinematics
