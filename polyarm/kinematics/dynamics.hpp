#pragma once
/// Torques, accelerations and mass matrices of a tree of rigid bodies: what the links' masses ask of the
/// joints. Friction, damping and the inertia of motors are not in it. SI: kg, m, rad, N m (N where a joint
/// slides).
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/kinematics/tree.hpp"

namespace polyarm::kinematics {

/// Joint states are those of Tree: q has positions() values; v, accelerations and torques velocities(). The
/// torque of a joint that others mimic is what it has to bring for all of them.
/// Batches: `states` states; joint_after_joint: value i of state s at i * states + s (fastest),
/// state_after_state: at s * values + i. A batch and one state after the other give the same bits.
/// Thread: one at a time, for it has room to calculate in; a copy has its own. Nothing but the constructor
/// allocates or throws; all else may be called in the control cycle. Precondition: sizes as stated.
class Dynamics {
 public:
  explicit Dynamics(const Tree& tree, InstructionSet set = fastest_instructions());
  const Tree& tree() const noexcept { return tree_; }
  InstructionSet instructions() const noexcept { return set_; }

  /// The torques that give these accelerations: M a + bias.
  void inverse(std::span<const double> q, std::span<const double> v, std::span<const double> a,
               std::span<double> tau) noexcept;
  /// The torques that hold the robot still against gravity.
  void gravity(std::span<const double> q, std::span<double> tau) noexcept;
  /// The torques at zero acceleration: gravity, centrifugal and Coriolis forces.
  void bias(std::span<const double> q, std::span<const double> v, std::span<double> tau) noexcept;
  /// velocities() by velocities(), symmetric, row after row.
  void mass_matrix(std::span<const double> q, std::span<double> M) noexcept;
  /// The accelerations that these torques give. False, and no numbers to use, where the mass matrix is not
  /// positive definite: something moves without mass.
  [[nodiscard]] bool forward(std::span<const double> q, std::span<const double> v,
                             std::span<const double> tau, std::span<double> a) noexcept;

  void inverse_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                     std::span<const double> v, std::span<const double> a, std::span<double> tau) noexcept;
  void gravity_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                     std::span<double> tau) noexcept;
  void mass_matrix_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                         std::span<double> M) noexcept;
  [[nodiscard]] bool forward_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                                   std::span<const double> v, std::span<const double> tau,
                                   std::span<double> a) noexcept;

 private:
  struct alignas(64) Vector {
    std::array<double, 8> values;
  };
  double* scratch() noexcept { return scratch_.front().values.data(); }

  Tree tree_;
  InstructionSet set_;
  const TreeKernels *one_, *many_;
  std::vector<Vector> scratch_;
};

}  // namespace polyarm::kinematics
