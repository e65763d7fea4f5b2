#pragma once
/// Arms with joints that slide, in closed form: SCARAs (three parallel turning axes and one that slides along
/// them, in any order) and gantries (three that slide, then one to three that turn). Used inside this room
/// only.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

class SlidingArm {
 public:
  static constexpr std::size_t kMost = 2;
  using State = std::array<double, ArmGeometry::kMostAxes>;

  enum class Kind { none, scara, gantry };
  /// What `arm` is. Axes parallel within kLooseTolerance count as parallel.
  static Kind kind_of(const ArmGeometry& arm) noexcept;
  /// Precondition: `arm` is one of the two, and outlives this.
  SlidingArm(const ArmGeometry& arm, Kind kind) noexcept;

  /// Both solutions; where there is none, states near the pose. `seed` (values of the arm's axes) decides
  /// where endlessly many lead there. Allocates nothing.
  std::size_t solve(const PoseTarget& target, const double* seed, std::span<State, kMost> out) const noexcept;

 private:
  void solve_scara(const PoseTarget& target, const double* seed, double side, State& out) const noexcept;
  void solve_gantry(const PoseTarget& target, const double* seed, double side, State& out) const noexcept;
  void turn_wrist(const Rotation& turn, const double* seed, double side, State& out) const noexcept;

  const ArmGeometry* arm_;
  Kind kind_;
  std::array<std::size_t, 3> turning_{};  ///< of a SCARA
  std::array<double, 3> sign_{};
  std::size_t sliding_ = 0;
};

}  // namespace polyarm::kinematics
