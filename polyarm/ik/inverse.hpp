#pragma once
/// Inverse kinematics with an answer for a person: all branches of the closed form where an arm has one,
/// descents else, within joint limits, and a reason where there is none. Deterministic: the same question has
/// the same answer. Metres, radians, poses of the TCP in the world. Any thread; not for the control cycle
/// (results allocate; NumericIk and InverseKinematics are for that). Each call makes a solver for the chain,
/// some 60 us; an ArmSolver keeps one.
#include <span>
#include <string>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::kinematics {

/// `unreachable`: no joint state at all was found near the pose. `limits`: one was found, but outside joint
/// limits. `no_convergence`: the iteration came close and stayed there, or the question was malformed.
enum class IkStatus { solved, unreachable, limits, no_convergence };
const char* name(IkStatus status);

struct IkOptions {
  double position_tolerance = 1e-6;     ///< m; solutions are polished well beyond it
  double orientation_tolerance = 1e-6;  ///< rad
  int iterations = 60;                  ///< of one descent
  int restarts = 100;                   ///< how long other states are tried after the seed; 0: not at all
  /// Metres that one radian of orientation counts as while errors are traded against each other; matters to
  /// arms of fewer than six joints, whose failed solves report the best compromise.
  double orientation_weight = 1;
  bool orientation_free = false;  ///< only the position counts
};

struct IkResult {
  IkStatus status = IkStatus::no_convergence;
  std::vector<double> q;         ///< the solution, else the nearest found; within limits
  double position_error = 0;     ///< of `q`, m
  double orientation_error = 0;  ///< of `q`, rad
  std::string reason;            ///< why it failed, with numbers, for a person; empty when solved
  explicit operator bool() const { return status == IkStatus::solved; }
};

/// The solution that descent from `seed` finds, or descent from other states when that fails. Joints that
/// turn further than once come to the turn nearest the seed. Actuated joints that do not move the TCP keep
/// the seed's values. Never throws for any numbers: a target or seed that is malformed fails with its reason.
/// Method: damped least squares with damping proportional to the squared error (Chan and Lawrence 1988;
/// Sugihara 2011), first free and wound back into the limits, then with the limits as walls.
IkResult solve_inverse(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options = {});

/// Distinct solutions, nearest to `rank_from` (Euclidean distance of joint states) first: all branches of the
/// arm's closed form (InverseKinematics), else those found by descent from `rank_from` and options.restarts
/// other states. At most 64, as arms of more than six joints have endlessly many.
std::vector<std::vector<double>> find_solutions(const Chain& chain, const Pose& target,
                                                std::span<const double> rank_from,
                                                const IkOptions& options = {});

/// What a move wants. Descent from `current`, if it ends near and not close to a singularity; else, of all
/// solutions found and preferring those not close to a singularity, the one nearest to `current`, a tie going
/// to the one nearest `home`. "Near": no joint by more than kNearby; "close to a singularity": below
/// kSingular; neighbours within kSameBranch are taken whatever their singular value, so that a small step
/// never turns into a change of branch.
IkResult solve_nearest(const Chain& chain, const Pose& target, std::span<const double> current,
                       std::span<const double> home, const IkOptions& options = {});
inline constexpr double kNearby = 2.2;        // rad or m: the same configuration, unless it ends very near a singularity
inline constexpr double kSameBranch = 0.2;  // rad
inline constexpr double kVerySingular = 0.001;  // of smallest_singular_value()

}  // namespace polyarm::kinematics
