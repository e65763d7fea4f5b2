#include "polyarm/ik/inverse.hpp"

#include "polyarm/ik/arm_solver.hpp"

namespace polyarm::kinematics {

const char* name(IkStatus status) {
  switch (status) {
    case IkStatus::solved:
      return "solved";
    case IkStatus::unreachable:
      return "unreachable";
    case IkStatus::limits:
      return "limits";
    case IkStatus::no_convergence:
      return "no_convergence";
  }
  return "";
}

IkResult solve_inverse(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options) {
  return ArmSolver(chain, options).solve(target, seed);
}

std::vector<std::vector<double>> find_solutions(const Chain& chain, const Pose& target,
                                                std::span<const double> rank_from, const IkOptions& options) {
  return ArmSolver(chain, options).find_solutions(target, rank_from);
}

IkResult solve_nearest(const Chain& chain, const Pose& target, std::span<const double> current,
                       std::span<const double> home, const IkOptions& options) {
  return ArmSolver(chain, options).solve_nearest(target, current, home);
}

}  // namespace polyarm::kinematics
