#pragma once
/// Arms of seven turning axes whose first or last axis may be the redundant one while the other six have a
/// fast closed form. Another value of that axis is another pose for the same six axes, so eight values are
/// solved as eight poses side by side (for the Panda by its last angle: He and Liu 2021, "Analytical inverse
/// kinematics for Franka Emika Panda"). Private to the rooms closed_form and ik. Metres, radians, world
/// frame; const after construction: any thread.
#include <optional>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

class SpareEnd {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;

  /// Returns nothing if neither end leaves such a form.
  static std::optional<SpareEnd> of(const ArmGeometry& arm, const LaneLimits& limits);

  std::size_t axis() const noexcept { return axis_; }

  static constexpr std::size_t kMostDips = 8;
  /// Joint states within limits that reach the target, at the local minima of the distance from `seed` (a
  /// joint state) over 32 values of the spare axis, nearest first. SelfMotion slides from one of them to the
  /// nearest state. Returns their number; 0 if no tried value reaches the target. Allocates nothing.
  std::size_t dips(const Pose& target, const double* seed, std::span<State, kMostDips> out) const noexcept;

 private:
  /// `values` are eight evenly spaced values.
  void ask(const Pose& target, const double* seed, double first, double step, QuickAnswers& found,
           double* costs) const noexcept;

  std::size_t axis_ = 0, joint_ = 0;  ///< of the spare axis
  bool last_ = false;
  Vec3 direction_, point_;  ///< of the spare axis: in the frame of the tool at zero if it is the last one,
                            ///< else in the world
  double lower_ = 0, upper_ = 0, weight_ = 1;
  QuickJob job_;
  LaneArm six_;
};

}  // namespace polyarm::kinematics
