#pragma once
/// Seven turning axes of which the first or the last may be the one to spare and the other six have a quick
/// closed form: another value of that axis is another pose for the same six, so eight values are eight poses
/// side by side (for the Panda by its last angle: He and Liu 2021, "Analytical inverse kinematics for Franka
/// Emika Panda"). Used inside this room only.
#include <optional>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

class SpareEnd {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;

  /// Nothing where neither end leaves such a form.
  static std::optional<SpareEnd> of(const ArmGeometry& arm, const LaneLimits& limits);

  std::size_t axis() const noexcept { return axis_; }

  static constexpr std::size_t kMostDips = 8;
  /// Joint states within limits that lead to the target, of which one slides (SelfMotion) to the one that is
  /// nearest to `seed` (a joint state): where the distance has a dip over 32 values of the spare axis, the
  /// nearer first. Returns how many; 0 where no value that was looked at leads there. Allocates nothing.
  std::size_t dips(const Pose& target, const double* seed, std::span<State, kMostDips> out) const noexcept;

 private:
  /// `values` eight of them, evenly spaced.
  void ask(const Pose& target, const double* seed, double first, double step, QuickAnswers& found,
           double* costs) const noexcept;

  std::size_t axis_ = 0, joint_ = 0;  ///< of the spare one
  bool last_ = false;
  Vec3 direction_, point_;  ///< of it: as the tool at zero sees them where it is the last, else in the world
  double lower_ = 0, upper_ = 0, weight_ = 1;
  QuickJob job_;
  LaneArm six_;
};

}  // namespace polyarm::kinematics
