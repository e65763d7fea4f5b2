#pragma once
/// Inverse kinematics by iteration for every chain: any number of joints, sliding joints and followers
/// included, within joint limits, for whole and partial poses. Metres, radians; poses of the TCP in the
/// world.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"
#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::kinematics {

struct NumericSettings {
  double position_tolerance = 1e-6;     ///< m
  double orientation_tolerance = 1e-6;  ///< rad
  /// After the tolerances are met, polish to rounding if a few steps suffice.
  bool polish = true;
  int steps = 1500;         ///< of eight descents, before solve() gives up
  int track_steps = 20;     ///< maximum for track()
  int searches = 160;       ///< descents in solve_all()
  std::size_t seeds = 512;  ///< size of the table of start states
  IkGoal goal = IkGoal::none;
  int goal_steps = 24;
  std::vector<double> weights;  ///< weight of each joint's change, per rad or m, in distances; empty: 1 each
};
inline constexpr double kAwayFromSingular = 0.03;  ///< of the smallest singular value, see singularity.hpp

struct NumericCore;

/// Damped least squares (Chan and Lawrence 1988; Nakamura and Hanafusa 1986) with joint limits as walls, in
/// eight descents side by side, from the seed and from the nearest states of a table.
/// Built once (some 100 us, allocates), then const and without hidden state: any thread. Nothing else here
/// allocates, locks, throws or reads a clock, and the work is bounded, so all of it may run in the control
/// cycle; it uses some 60 kB of stack. The same question has the same answer, bit for bit on processors with
/// the same vector instructions.
class NumericIk {
 public:
  /// Copies what it needs from `chain`. Throws Error("bad-model") for more than 64 joints and followers.
  explicit NumericIk(const Chain& chain, NumericSettings settings = {});
  /// For the same arm with other settings; shares the arm's data (settings.seeds is ignored).
  NumericIk(const NumericIk& same_arm, NumericSettings settings);
  ~NumericIk();
  NumericIk(NumericIk&&) noexcept;
  NumericIk& operator=(NumericIk&&) noexcept;

  /// Any solution within limits; of those found in the same step the nearest to `seed`, a joint state of the
  /// chain. A joint that can turn more than once takes the turn nearest the seed; a joint that does not move
  /// the TCP keeps the seed's value. If none is found, `out` is the state within limits that came nearest to
  /// the pose, and not exact; the outcome is `limits` if there is a solution outside the limits.
  IkOutcome solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// The solution that one descent from `seed` reaches, for servo ticks; usually two steps of third order,
  /// for one arm alone. It ends within tolerance, with or without polish. If the descent does not reach the
  /// target, `out` is where it ended.
  IkOutcome track(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome track(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// Distinct solutions within limits from settings.searches descents, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, std::span<const double> seed, IkSolutions& out) const noexcept;
  IkOutcome solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                      IkSolutions& out) const noexcept;
  /// One solution for each target, eight in parallel. `seeds`: a joint state for each target, one after the
  /// other; if empty, joints take the turn nearest zero. Returns the number of solved targets; the other
  /// solutions are not exact. All three sizes must match.
  std::size_t solve_batch(std::span<const Pose> targets, std::span<const double> seeds,
                          std::span<IkSolution> out) const noexcept;

  const NumericSettings& settings() const noexcept;
  const NumericCore& core() const noexcept { return *core_; }

 private:
  std::unique_ptr<const NumericCore> core_;
};

}  // namespace polyarm::kinematics
