#pragma once
/// Joint torques, accelerations and mass matrices of a tree of rigid bodies. Friction, damping and motor
/// inertia are not included. SI units: kg, m, rad, N m (N for sliding joints).
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/kinematics/tree.hpp"

namespace polyarm::kinematics {

/// Joint states are those of Tree: q has positions() values; v, accelerations and torques have velocities()
/// values. The torque of a joint that others mimic is the total for all of them.
/// Batches have `states` states. joint_after_joint: value i of state s is at i * states + s (fastest).
/// state_after_state: it is at s * values + i. A batch gives the same bits as single calls.
/// Thread: one thread at a time, because the object contains scratch memory; each copy has its own. Only the
/// constructor allocates or throws; all other functions may run in the control cycle. Precondition: spans
/// have the sizes stated.
class Dynamics {
 public:
  explicit Dynamics(const Tree& tree, InstructionSet set = fastest_instructions());
  const Tree& tree() const noexcept { return tree_; }
  InstructionSet instructions() const noexcept { return set_; }

  /// The torques for these accelerations: M a + bias.
  void inverse(std::span<const double> q, std::span<const double> v, std::span<const double> a,
               std::span<double> tau) noexcept;
  /// The torques that hold the robot at rest against gravity.
  void gravity(std::span<const double> q, std::span<double> tau) noexcept;
  /// The torques at zero acceleration: gravity, centrifugal and Coriolis terms.
  void bias(std::span<const double> q, std::span<const double> v, std::span<double> tau) noexcept;
  /// velocities() by velocities(), symmetric, row-major.
  void mass_matrix(std::span<const double> q, std::span<double> M) noexcept;
  /// The accelerations for these torques. Returns false, and no usable values, if the mass matrix is not
  /// positive definite: some joint moves no mass.
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
