#pragma once
/// Inverse kinematics by iteration, within joint limits, from seeds. Deterministic: no clock, fixed random seeds.
#include <span>
#include <string>
#include <vector>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

enum class IkStatus { solved, unreachable, limits, no_convergence };
const char* name(IkStatus status);

struct IkOptions {
  double position_tolerance = 1e-6;     ///< m
  double orientation_tolerance = 1e-6;  ///< rad
  int iterations = 60;                  ///< of one descent
  int restarts = 60;                    ///< random seeds tried after the given one
  bool orientation_free = false;        ///< only the position counts (fewer than six joints, spraying, pointing)
};

struct IkResult {
  IkStatus status = IkStatus::no_convergence;
  std::vector<double> q;          ///< the solution, else the nearest found
  double position_error = 0;      ///< m
  double orientation_error = 0;   ///< rad
  std::string reason;             ///< why it failed, with numbers, for a person
  explicit operator bool() const { return status == IkStatus::solved; }
};

/// The solution that descent from `seed` finds, or from random seeds when that fails. Damped least squares with the
/// damping of Chan and Lawrence (proportional to the error), limits kept by projection, joints that turn brought to
/// the turn nearest the seed.
IkResult solve_inverse(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options = {});

/// Distinct solutions found from many seeds, nearest to `rank_from` first.
std::vector<std::vector<double>> find_solutions(const Chain& chain, const Pose& target,
                                                std::span<const double> rank_from, const IkOptions& options = {});

/// What a move wants: the solution in the configuration of `current` if descent from there ends near; else the one
/// nearest to `current` among all found, ties going to the one nearest `home`.
IkResult solve_nearest(const Chain& chain, const Pose& target, std::span<const double> current,
                       std::span<const double> home, const IkOptions& options = {});

}  // namespace polyarm::kinematics
