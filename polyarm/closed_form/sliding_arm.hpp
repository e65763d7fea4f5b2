#pragma once
/// Closed forms for arms with sliding joints: SCARAs (three parallel turning axes and one that slides along
/// them, in any order) and gantries (three sliding axes, then one to three turning ones). Private to the
/// rooms closed_form and ik. Metres, radians, world frame; const after construction: any thread. Nothing
/// throws.
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
  /// The kind of `arm`. Axes parallel within kLooseTolerance count as parallel.
  static Kind kind_of(const ArmGeometry& arm) noexcept;
  /// Precondition: `arm` is a SCARA or a gantry, and outlives this object.
  SlidingArm(const ArmGeometry& arm, Kind kind) noexcept;

  /// Both solutions; if there is none, states near the pose. `seed` (values of the arm's axes) selects one of
  /// infinitely many. Allocates nothing.
  std::size_t solve(const PoseTarget& target, const double* seed, std::span<State, kMost> out) const noexcept;

 private:
  void solve_scara(const PoseTarget& target, const double* seed, double side, State& out) const noexcept;
  void solve_gantry(const PoseTarget& target, const double* seed, double side, State& out) const noexcept;
  void turn_wrist(const Rotation& turn, const double* seed, double side, State& out) const noexcept;

  const ArmGeometry* arm_;
  Kind kind_;
  std::array<std::size_t, 3> turning_{};  ///< for a SCARA
  std::array<double, 3> sign_{};
  std::size_t sliding_ = 0;
};

}  // namespace polyarm::kinematics
