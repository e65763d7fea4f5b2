#pragma once
/// The inverse kinematics of one robot, kept: what solve_inverse(), find_solutions() and solve_nearest() of
/// inverse.hpp do, without making a solver anew for each question.
#include <memory>
#include <span>
#include <vector>

#include "polyarm/ik/inverse.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/descent/numeric_ik.hpp"

namespace polyarm::kinematics {

/// Closed form where the arm has one, descents from the nearest of a table of states else. Made in some 100
/// us; then const and without hidden state, any thread. Results allocate, so it is not for the control cycle;
/// numeric() and closed_form() are. The same question has the same answer, also that of the functions in
/// inverse.hpp.
class ArmSolver {
 public:
  /// Keeps nothing of `chain` but copies.
  explicit ArmSolver(const Chain& chain, const IkOptions& options = {});
  ~ArmSolver();
  ArmSolver(ArmSolver&&) noexcept;
  ArmSolver& operator=(ArmSolver&&) noexcept;

  const Chain& chain() const noexcept;
  const IkOptions& options() const noexcept;
  const NumericIk& numeric() const noexcept;
  const InverseKinematics& closed_form() const noexcept;

  /// A joint state that has what `task` (numeric_ik.hpp) asks of the pose. Errors in the result are what is
  /// beyond the task's tolerances; options.orientation_free and orientation_weight are the task's matter.
  IkResult solve(const Pose& target, const IkTask& task, std::span<const double> seed) const;
  /// As the functions of the same names in inverse.hpp, with the options of the construction.
  IkResult solve(const Pose& target, std::span<const double> seed) const;
  std::vector<std::vector<double>> find_solutions(const Pose& target,
                                                  std::span<const double> rank_from) const;
  IkResult solve_nearest(const Pose& target, std::span<const double> current,
                         std::span<const double> home) const;

 private:
  struct Arm;
  std::unique_ptr<const Arm> arm_;
};

}  // namespace polyarm::kinematics
